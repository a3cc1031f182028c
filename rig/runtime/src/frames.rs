//! Frames of buses between plan and board: who counts them, what they carry, what is sent.

use drivers::{Board, BoardExt, Bus, BusId, BusKind};
use plans::frames::can::{FramePattern, FrameSignal, FrameView};
use plans::steps::OutFrame;
use signal::{CanFrame, MAX_CAN_DATA, SignalId, SignalInfo, Value, ValueKind};
use std::sync::Arc;

/// What a signal shows of the frames that it stands for.
#[derive(Clone, Debug)]
enum Shows {
    /// How many there were.
    Count(i64),
    /// The value that the last one carried.
    Value(Arc<FrameSignal>),
    /// The same, as a number with a name.
    Named(Arc<FrameSignal>),
}

/// A signal that follows the frames of a bus.
#[derive(Clone, Debug)]
pub struct FrameWatch {
    /// The signal.
    pub signal: SignalId,
    pattern: Arc<FramePattern>,
    shows: Shows,
}

impl FrameWatch {
    /// Counts frames.
    pub fn counting(signal: SignalId, pattern: Arc<FramePattern>) -> FrameWatch {
        FrameWatch { signal, pattern, shows: Shows::Count(0) }
    }

    /// Shows the value that frames carry.
    pub fn reading(signal: SignalId, source: &Arc<FrameSignal>) -> FrameWatch {
        let shows = match has_names(source) {
            true => Shows::Named(Arc::clone(source)),
            false => Shows::Value(Arc::clone(source)),
        };
        FrameWatch { signal, pattern: Arc::new(source.pattern.clone()), shows }
    }

    /// What the signal is before any frame; `None` for what only a frame shows.
    pub fn initial(&self) -> Option<Value> {
        match self.shows {
            Shows::Count(count) => Some(Value::Int(count)),
            Shows::Value(_) | Shows::Named(_) => None,
        }
    }

    /// A frame was on the bus: what the signal is from then on, where it stands for it. Nothing is allocated.
    #[inline]
    pub fn see(&mut self, frame: &CanFrame, own: bool) -> Option<Value> {
        let data = frame.data();
        let CanFrame { id, extended, remote, fd, .. } = *frame;
        if !self.pattern.matches(&FrameView { id, extended, remote, fd, data, own }) {
            return None;
        }
        let selected = |source: &FrameSignal| match &source.field.selector {
            Some(selector) => selector.selects(data),
            None => true,
        };
        match &mut self.shows {
            Shows::Count(count) => {
                *count += 1;
                Some(Value::Int(*count))
            }
            Shows::Value(source) => selected(source).then(|| source.field.coding.value(data)),
            Shows::Named(source) => selected(source).then(|| {
                let number = source.field.coding.number(data).and_then(|number| i64::try_from(number).ok());
                number.map_or(Value::Unknown, Value::Int)
            }),
        }
    }
}

/// Whether the values of a signal are names rather than numbers.
fn has_names(source: &FrameSignal) -> bool {
    let field = &source.field;
    !field.labels.is_empty() && field.unit.is_empty() && field.coding.is_plain()
}

/// The signal of a number of frames.
pub fn count_info(name: &str, bus: &Bus) -> SignalInfo {
    stamped(SignalInfo::exact(name, ValueKind::Int), bus)
}

/// The signal of a value in frames.
pub fn value_info(name: &str, source: &FrameSignal, bus: &Bus) -> SignalInfo {
    let field = &source.field;
    let info = match has_names(source) {
        true => SignalInfo { labels: field.labels.clone(), ..SignalInfo::exact(name, ValueKind::State) },
        false => SignalInfo { unit: field.unit.clone(), ..SignalInfo::exact(name, ValueKind::Real) },
    };
    stamped(info, bus)
}

/// With what is known of the instants of a bus.
fn stamped(info: SignalInfo, bus: &Bus) -> SignalInfo {
    SignalInfo { sampling: signal::Sampling::Edges { resolution: bus.resolution }, ..info }
}

/// The CAN bus of this name.
pub fn find<'b>(board: &'b dyn Board, name: &str) -> Option<(BusId, &'b Bus)> {
    let place = board.bus_list().iter().position(|bus| bus.name == name)?;
    let bus = &board.bus_list()[place];
    matches!(bus.kind, BusKind::Can { .. }).then_some((BusId(u16::try_from(place).ok()?), bus))
}

/// Why a board has not got the bus of this name.
pub fn lacks(board: &dyn Board, name: &str) -> Option<String> {
    if find(board, name).is_some() {
        return None;
    }
    Some(match board.bus_list().iter().any(|bus| bus.name == name) {
        true => format!("bus `{name}` of the board carries no frames"),
        false => format!("the board has no bus `{name}`"),
    })
}

/// What to write in place of a bus that a board has not got.
pub fn known(board: &dyn Board, name: &str) -> String {
    let carries = |bus: &&Bus| matches!(bus.kind, BusKind::Can { .. });
    let names: Vec<&str> = board.bus_list().iter().filter(carries).map(|bus| bus.name.as_str()).collect();
    match document::suggest(name, names.iter().copied()) {
        Some(meant) => format!("did you mean `{meant}`?"),
        None if names.is_empty() => String::from("describe one under `[buses]` of the board file"),
        None => format!("the buses that carry frames are {}", names.join(", ")),
    }
}

/// A frame as the board takes it; `Err` says why the bus cannot carry it.
///
/// # Errors
/// One sentence.
pub fn outgoing(frame: &OutFrame, bus: &Bus) -> Result<CanFrame, String> {
    let BusKind::Can { data_bitrate, .. } = bus.kind else {
        return Err(format!("bus `{}` carries no frames", bus.name));
    };
    if frame.fd && data_bitrate.is_none() {
        return Err(format!("bus `{}` carries classic frames only", bus.name));
    }
    let mut data = [0; MAX_CAN_DATA];
    let length = frame.data.len().min(MAX_CAN_DATA);
    data[..length].copy_from_slice(&frame.data[..length]);
    Ok(CanFrame {
        id: frame.id,
        extended: frame.extended,
        remote: frame.remote,
        fd: frame.fd,
        brs: frame.brs,
        esi: false,
        len: frame.length,
        data,
    })
}
