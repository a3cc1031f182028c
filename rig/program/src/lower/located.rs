//! Variables at addresses, and the addresses themselves.

use super::{Compiler, Home, Symbol, Type};
use crate::codes::Code;
use crate::findings::{At, count};
use crate::parse::ast::{Initial, PouKind, Section, SectionKind, VarDecl};
use crate::program::Retention;
use signal::Address;

impl Compiler<'_> {
    pub(super) fn located_variable(
        &mut self,
        decl: &VarDecl,
        address: &(String, At),
        section: &Section,
        kind: PouKind,
        ty: Type,
    ) {
        let name = &decl.name;
        if kind != PouKind::Program
            || section.kind == SectionKind::Input
            || section.kind == SectionKind::Output
        {
            let message = format!("`{}` cannot be located here", name.text);
            self.findings.error(
                Code::Located,
                address.1,
                message,
                "locate variables in VAR of a PROGRAM or in VAR_GLOBAL",
            );
            return;
        }
        if section.retention != Retention::None || section.constant {
            let message = format!("`{}` is located: it cannot be CONSTANT, RETAIN or PERSISTENT", name.text);
            self.findings.error(Code::Located, address.1, message, "where it lies decides what is kept");
            return;
        }
        let Some(place) = self.address(&address.0, address.1) else { return };
        let Type::One(ty) = ty else {
            if ty != Type::Wrong {
                let help = "locate variables of elementary types";
                self.findings.error(
                    Code::Unsupported,
                    decl.ty.at(),
                    "such a located variable is not supported yet",
                    help,
                );
            }
            return;
        };
        if !ty.fits(place.size()) {
            let message =
                format!("{} has {}, {place} has {}", ty.name(), count(ty.bits(), "bit"), place.size().bits());
            self.findings.error(
                Code::AddressSize,
                decl.ty.at(),
                message,
                "choose the type or the address to suit",
            );
            return;
        }
        let entry = self.locate(place, ty);
        let initial = match &decl.initial {
            Some(Initial::One(value)) => self.constant_of(value, ty),
            Some(Initial::List(_, at)) => {
                self.findings.error(Code::InitialValue, *at, format!("{} takes one value", ty.name()), "");
                None
            }
            None => None,
        };
        if let Some(located) = self.located.get_mut(entry as usize) {
            located.declared = true;
            if let Some(initial) = initial {
                let mask = if ty.bits() == 64 { u64::MAX } else { (1 << ty.bits()) - 1 };
                located.initial = Some(initial as u64 & mask);
            }
        }
        let symbol = Symbol::Variable {
            ty: Type::One(ty),
            home: Home::Located(entry),
            retention: Retention::None,
            constant: false,
        };
        self.add(name, section.kind, symbol, decl.initial.is_some());
    }

    /// An address that exists; reports it otherwise (controller:ADDR-02, controller:ADDR-04).
    pub(super) fn address(&mut self, text: &str, at: At) -> Option<Address> {
        match Address::parse(text)
            .and_then(|address| address.check(&self.options.limits.addresses).map(|()| address))
        {
            Ok(address) => Some(address),
            Err(error) => {
                let start = (at.start + error.offset() as u32).min(at.end);
                self.findings.error(Code::Address, At { start, ..at }, error.to_string(), "");
                None
            }
        }
    }
}
