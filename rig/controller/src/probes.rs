//! The observed probes with their last values.

use crate::probe::{Probe, ProbeId};
use profile::{PlcRead, SystemField};
use signal::Value;

/// What can change together: probes are looked at only when something of their kind happened.
pub(crate) mod class {
    pub const MEMORY: u16 = 1;
    pub const VARIABLE: u16 = 2;
    pub const STATE: u16 = 4;
    pub const FIGURE: u16 = 8;
    pub const TERMINAL: u16 = 16;
    pub const INPUT: u16 = 32;
    pub const LED: u16 = 64;
    pub const FILE: u16 = 128;
    pub const EXPERT: u16 = 256;
    pub const ALL: u16 = 511;
}

fn class_of(probe: &Probe) -> u16 {
    match probe {
        Probe::Address(_) => class::MEMORY,
        Probe::Variable(_) => class::VARIABLE,
        Probe::System(variable) if variable.field == SystemField::PlcR(PlcRead::FreeBytes) => {
            class::STATE | class::FILE
        }
        Probe::State | Probe::System(_) | Probe::Led(_) => class::STATE,
        Probe::LedLit(_) => class::STATE | class::LED,
        Probe::TaskFigure { .. } => class::FIGURE,
        Probe::Input { .. } => class::INPUT,
        Probe::Terminal(_) | Probe::Output(_) => class::TERMINAL,
        Probe::File(_) => class::FILE,
        Probe::Expert { .. } => class::EXPERT,
        Probe::Register(_) => class::MEMORY | class::VARIABLE | class::STATE | class::FILE,
    }
}

/// The observed probes with their last values.
#[derive(Clone, Debug, Default)]
pub(crate) struct ObservedProbes {
    /// Nothing at the places of those that are observed no more: the next ones take them.
    list: Vec<Option<(Probe, Value)>>,
    /// Of the observed probes; of some that were, too, while `stale`.
    classes: u16,
    /// A probe went, and marks that it had in common with others went with it.
    stale: bool,
}

impl ObservedProbes {
    /// The number of a probe that is observed.
    pub(crate) fn find(&self, probe: &Probe) -> Option<ProbeId> {
        let place = self.list.iter().position(|at| at.is_some_and(|(at, _)| at == *probe));
        place.map(|place| ProbeId(place as u32))
    }

    /// Observes a probe that shows `value` now.
    pub(crate) fn add(&mut self, probe: Probe, value: Value) -> ProbeId {
        self.classes |= class_of(&probe);
        let free = self.list.iter().position(Option::is_none);
        let place = free.unwrap_or(self.list.len());
        match self.list.get_mut(place) {
            Some(free) => *free = Some((probe, value)),
            None => self.list.push(Some((probe, value))),
        }
        ProbeId(place as u32)
    }

    /// Observes a probe no more; which one that was.
    pub(crate) fn remove(&mut self, probe: ProbeId) -> Option<Probe> {
        let (probe, _) = self.list.get_mut(probe.0 as usize).and_then(Option::take)?;
        self.stale = true;
        Some(probe)
    }

    /// Room for so many observed probes.
    pub(crate) fn reserve(&mut self, probes: usize) {
        self.list.reserve(probes.saturating_sub(self.list.len()));
    }

    /// Past the last number of an observed probe.
    pub(crate) fn len(&self) -> usize {
        self.list.len()
    }

    /// The probe of this number.
    #[inline]
    pub(crate) fn get(&self, place: usize) -> Option<Probe> {
        self.list.get(place)?.map(|(probe, _)| probe)
    }

    /// Every observed probe.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Probe> {
        self.list.iter().flatten().map(|(probe, _)| probe)
    }

    /// The probe of this number, if it is of one of these classes.
    #[inline]
    pub(crate) fn of_class(&self, place: usize, classes: u16) -> Option<Probe> {
        self.get(place).filter(|probe| class_of(probe) & classes != 0)
    }

    /// The probe of this number shows this value: whether it is another one.
    #[inline]
    pub(crate) fn update(&mut self, place: usize, value: Value) -> bool {
        match self.list.get_mut(place) {
            Some(Some((_, last))) if *last != value => {
                *last = value;
                true
            }
            _ => false,
        }
    }

    /// Whether a probe of these classes is observed.
    #[inline]
    pub(crate) const fn has_class(&self, classes: u16) -> bool {
        self.classes & classes != 0
    }

    /// Whether a probe went since the last call. The classes are then those of the others.
    #[inline]
    pub(crate) fn take_stale(&mut self) -> bool {
        let stale = std::mem::take(&mut self.stale);
        if stale {
            self.classes =
                self.list.iter().flatten().fold(0, |classes, (probe, _)| classes | class_of(probe));
        }
        stale
    }
}
