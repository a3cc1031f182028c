//! The capabilities of a board for callers who do not care whether it has them.

use signal::{CanFrame, SerialOutput, SerialSettings, Span, Time, When};

use super::{Board, BoardError};
use crate::bus::{Bus, BusEvent, BusId};
use crate::channel::{ChannelId, Emission, Fault, NotEmitted};

/// The capabilities of any board: what it lacks it refuses, or has nothing of. Nobody implements this but the board itself,
/// by its accessors.
pub trait BoardExt: Board {
    /// The channel of this name.
    fn find(&self, name: &str) -> Option<ChannelId> {
        let place = self.channels().iter().position(|channel| channel.name == name)?;
        u16::try_from(place).ok().map(ChannelId)
    }

    /// As [`Buses::bus_list`](super::Buses::bus_list); empty without buses.
    fn bus_list(&self) -> &[Bus] {
        self.buses().map_or(&[], |buses| buses.bus_list())
    }

    /// As [`Buses::bus_device`](super::Buses::bus_device).
    fn bus_device(&self, bus: BusId) -> Option<&str> {
        self.buses()?.bus_device(bus)
    }

    /// As [`Buses::send`](super::Buses::send).
    ///
    /// # Errors
    /// [`BoardError::NoBus`] without buses.
    fn send(&mut self, now: Time, bus: BusId, frame: &CanFrame) -> Result<(), BoardError> {
        self.buses_mut().map_or(Err(BoardError::NoBus(bus)), |buses| buses.send(now, bus, frame))
    }

    /// As [`Buses::send_serial`](super::Buses::send_serial).
    ///
    /// # Errors
    /// [`BoardError::NoBus`] without buses.
    fn send_serial(&mut self, now: Time, bus: BusId, output: &SerialOutput) -> Result<(), BoardError> {
        self.buses_mut().map_or(Err(BoardError::NoBus(bus)), |buses| buses.send_serial(now, bus, output))
    }

    /// As [`Buses::configure`](super::Buses::configure).
    ///
    /// # Errors
    /// [`BoardError::NoBus`] without buses.
    fn configure(
        &mut self,
        now: Time,
        bus: BusId,
        settings: &SerialSettings,
        message_gap: Span,
    ) -> Result<(), BoardError> {
        let buses = self.buses_mut().ok_or(BoardError::NoBus(bus))?;
        buses.configure(now, bus, settings, message_gap)
    }

    /// As [`Buses::break_off`](super::Buses::break_off).
    ///
    /// # Errors
    /// [`BoardError::NoBus`] without buses.
    fn break_off(&mut self, now: Time, bus: BusId) -> Result<(), BoardError> {
        self.buses_mut().map_or(Err(BoardError::NoBus(bus)), |buses| buses.break_off(now, bus))
    }

    /// As [`Buses::poll_buses`](super::Buses::poll_buses); nothing happens without buses.
    ///
    /// # Errors
    /// Those of the buses.
    fn poll_buses(&mut self, now: Time, out: &mut Vec<BusEvent>) -> Result<(), BoardError> {
        self.buses_mut().map_or(Ok(()), |buses| buses.poll_buses(now, out))
    }

    /// As [`PulseOutputs::emit`](super::PulseOutputs::emit).
    ///
    /// # Errors
    /// [`BoardError::NotEmitted`] without such outputs.
    fn emit(&mut self, now: Time, channel: ChannelId, emission: &Emission) -> Result<(), BoardError> {
        let none = Err(BoardError::NotEmitted(channel, NotEmitted::Nothing));
        self.pulse_outputs().map_or(none, |outputs| outputs.emit(now, channel, emission))
    }

    /// As [`FaultInjection::inject`](super::FaultInjection::inject).
    ///
    /// # Errors
    /// [`BoardError::NoSuchFault`] where no faults can be injected.
    fn inject(&mut self, now: Time, fault: Fault) -> Result<(), BoardError> {
        let none = Err(BoardError::NoSuchFault(fault.channel));
        self.faults_mut().map_or(none, |faults| faults.inject(now, fault))
    }

    /// As [`FaultInjection::clear_faults`](super::FaultInjection::clear_faults); there is nothing to clear where no faults
    /// can be injected.
    ///
    /// # Errors
    /// [`BoardError::NoChannel`].
    fn clear_faults(&mut self, now: Time, channel: ChannelId) -> Result<(), BoardError> {
        let known = usize::from(channel.0) < self.channels().len();
        match self.faults_mut() {
            Some(faults) => faults.clear_faults(now, channel),
            None if known => Ok(()),
            None => Err(BoardError::NoChannel(channel)),
        }
    }

    /// As [`FaultInjection::fault_switching_time`](super::FaultInjection::fault_switching_time); 0 without faults.
    fn fault_switching_time(&self, channel: ChannelId) -> Span {
        self.faults().map_or(Span::ZERO, |faults| faults.fault_switching_time(channel))
    }

    /// As [`FaultInjection::fault_settled_at`](super::FaultInjection::fault_settled_at).
    fn fault_settled_at(&self, channel: ChannelId) -> Option<When> {
        self.faults()?.fault_settled_at(channel)
    }

    /// As [`PlantParameters::set_parameter`](super::PlantParameters::set_parameter).
    ///
    /// # Errors
    /// [`BoardError::NoPlant`] without plants.
    fn set_parameter(
        &mut self,
        now: Time,
        plant: usize,
        parameter: usize,
        value: f64,
    ) -> Result<(), BoardError> {
        let plants = self.plant_parameters().ok_or(BoardError::NoPlant(plant))?;
        plants.set_parameter(now, plant, parameter, value)
    }

    /// As [`Descriptions::device`](super::Descriptions::device).
    fn device(&self, channel: ChannelId) -> Option<&str> {
        self.descriptions()?.device(channel)
    }

    /// As [`Descriptions::device_kind`](super::Descriptions::device_kind).
    fn device_kind(&self, channel: ChannelId) -> Option<&'static str> {
        self.descriptions()?.device_kind(channel)
    }

    /// As [`Descriptions::noise`](super::Descriptions::noise).
    fn noise(&self, channel: ChannelId) -> Option<f64> {
        self.descriptions()?.noise(channel)
    }
}

impl<B: Board + ?Sized> BoardExt for B {}
