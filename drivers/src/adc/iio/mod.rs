//! Converters that the kernel has a driver for: devices of the industrial I/O subsystem, by its files.
//!
//! A device is asked for one sample at a time, or samples by itself whenever a trigger fires, into a buffer of the
//! kernel with the instant of each scan.

mod asked;
mod buffered;
mod element;
mod files;
mod find;
mod info;
#[cfg(test)]
mod made_up;
mod scans;
mod spec;
mod trigger;

pub use element::{Element, SampleLayout};
pub use find::{find, inputs, named};
pub use info::{IioDevice, IioInput, list, unit_of};
pub use scans::{Sampled, Scans};
pub use spec::{Buffering, FindDevice, IioSpec, MAX_BUFFER};

use std::fs::File;
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use rustix::fs::OFlags;
use rustix::io::Errno;

use super::{Adc, AdcSpec, SampleSpec};
use crate::codes;
use crate::holder::{holders, words};
use crate::refusal::Refusal;
use asked::AskedAdc;
use buffered::BufferedAdc;

/// Opens a device for these inputs.
///
/// # Errors
/// It is not there, not free, not permitted, or cannot do this.
pub fn open(converter: &AdcSpec, spec: &IioSpec, samples: &[SampleSpec]) -> Result<Box<dyn Adc>, Refusal> {
    let root = Path::new("/");
    let device = find(root, spec)?;
    let places = inputs(&device, samples).map_err(|mut refused| refused.swap_remove(0))?;
    let inputs: Vec<&IioInput> = places.iter().filter_map(|at| device.inputs.get(*at)).collect();
    let node = device.node.as_deref().map(|node| take(&device, node)).transpose()?;
    match (&spec.buffered, node) {
        (None, node) => match AskedAdc::open(find::named(&device), converter.period, &inputs, node) {
            Ok(asked) => Ok(Box::new(asked)),
            Err(error) => Err(unreadable(&device, &error)),
        },
        (Some(buffering), Some(node)) => {
            BufferedAdc::open(root, &device, buffering, converter.period, &inputs, node)
                .map(|buffered| Box::new(buffered) as Box<dyn Adc>)
        }
        (Some(_), None) => {
            let message = format!("{} has no node to read samples from", find::named(&device));
            let help =
                "leave `buffered`, `trigger`, `buffer` and `watermark` out: each sample is asked for then";
            Err(Refusal::new(codes::IIO_BUFFER, message, help))
        }
    }
}

/// The device and the places of these inputs among its inputs. Its node is opened and let go again, to see whether
/// it is free.
///
/// # Errors
/// All that is not there, not free or not permitted.
pub fn look(spec: &IioSpec, samples: &[SampleSpec]) -> Result<(IioDevice, Vec<usize>), Vec<Refusal>> {
    let device = find(Path::new("/"), spec).map_err(|refused| vec![refused])?;
    let places = inputs(&device, samples)?;
    if let Some(node) = &device.node {
        drop(take(&device, node).map_err(|refused| vec![refused])?);
    }
    Ok((device, places))
}

/// Opens the node of a device, which the kernel gives to one program at a time.
fn take(device: &IioDevice, node: &Path) -> Result<File, Refusal> {
    let flags = (OFlags::NONBLOCK | OFlags::CLOEXEC).bits() as i32;
    File::options().read(true).custom_flags(flags).open(node).map_err(|error| {
        let message = format!("{} cannot be opened: {error}", node.display());
        match error.raw_os_error().map(Errno::from_raw_os_error) {
            Some(Errno::BUSY) => {
                let by = words(&holders(node), "another program");
                let message = format!("{} is held by {by}", find::named(device));
                let help =
                    format!("end it; `sudo fuser -v {}` names those that you may not see", node.display());
                Refusal::new(codes::IIO_BUSY, message, help)
            }
            Some(Errno::ACCESS | Errno::PERM) => denied(&message),
            _ => Refusal::new(codes::IIO_MISSING, message, "look into the kernel's log: `dmesg`"),
        }
    })
}

fn unreadable(device: &IioDevice, error: &io::Error) -> Refusal {
    let message = format!("the inputs of {} cannot be opened: {error}", find::named(device));
    match error.kind() {
        io::ErrorKind::PermissionDenied => denied(&message),
        _ => Refusal::new(codes::IIO_MISSING, message, "look into the kernel's log: `dmesg`"),
    }
}

/// The user lacks a right.
fn denied(message: &str) -> Refusal {
    let help = "give the device to a group of yours, its files in /sys too: a udev rule \
                `SUBSYSTEM==\"iio\", GROUP=\"iio\", MODE=\"0660\", RUN+=\"/bin/sh -c 'chgrp -R iio /sys%p; \
                chmod -R g+w /sys%p'\"`";
    Refusal::new(codes::IIO_DENIED, message, help)
}
