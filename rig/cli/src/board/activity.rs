//! What happens on channels, counted.

use drivers::{BoardEvent, Channel, LossReason, Origin};
use signal::{SignalGap, Value, When};

/// What happened on a channel since it was looked at first.
#[derive(Clone, Debug, Default)]
pub struct ChannelActivity {
    /// Its level; `None` before the first report and while its device is gone.
    pub level: Option<bool>,
    /// What it shows, where it is analog; `None` before the first report and while its device is gone.
    pub quantity: Option<AnalogQuantity>,
    /// The standard deviation of its samples in the last reading, where a reading is many.
    pub noise: Option<f64>,
    /// Changes from 0 to 1.
    pub rises: u64,
    /// Changes from 1 to 0.
    pub falls: u64,
    /// When it changed last.
    pub last: Option<When>,
    /// Changes that the board knows to have missed.
    pub dropped: u64,
    /// Why its device is gone, if it is.
    pub lost: Option<LossReason>,
    /// A first level was reported: what follows are changes.
    known: bool,
}

/// What an analog channel shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AnalogQuantity {
    /// A value of its unit.
    Is(Value),
    /// None, for this reason.
    NotKnown(SignalGap),
}

/// What an event was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ActivityChange {
    /// The first level of a channel.
    First(bool),
    /// Another level, at this instant.
    Change(bool, When),
    /// Another quantity, or one that is not known.
    Quantity(AnalogQuantity),
    /// The device of the channel is gone.
    Lost(LossReason),
    /// It is back.
    Returned,
    /// So many changes were missed.
    Dropped(u32),
    /// Nothing that a level has.
    Nothing,
}

impl ChannelActivity {
    /// Takes an event of the channel.
    pub fn take(&mut self, event: &BoardEvent) -> ActivityChange {
        match *event {
            BoardEvent::Changed { at, value: Value::Bool(level), .. } => {
                let before = self.level.replace(level);
                if !std::mem::replace(&mut self.known, true) || before.is_none() {
                    return ActivityChange::First(level);
                }
                self.last = Some(at);
                *(if level { &mut self.rises } else { &mut self.falls }) += 1;
                ActivityChange::Change(level, at)
            }
            BoardEvent::Changed {
                at,
                value: value @ (Value::Int(_) | Value::Real(_) | Value::Measured(..) | Value::Unknown),
                origin,
                ..
            } => {
                let quantity = match origin {
                    Origin::Gap(gap) => AnalogQuantity::NotKnown(gap),
                    _ => AnalogQuantity::Is(value),
                };
                (self.quantity, self.last) = (Some(quantity), Some(at));
                ActivityChange::Quantity(quantity)
            }
            BoardEvent::Changed { .. } => ActivityChange::Nothing,
            BoardEvent::Lost { reason, .. } => {
                (self.level, self.quantity, self.lost) = (None, None, Some(reason));
                ActivityChange::Lost(reason)
            }
            BoardEvent::Returned { .. } => {
                self.lost = None;
                ActivityChange::Returned
            }
            BoardEvent::Dropped { count, .. } => {
                self.dropped = self.dropped.saturating_add(u64::from(count));
                ActivityChange::Dropped(count)
            }
        }
    }

    /// Its level as a word.
    pub fn word(&self) -> &'static str {
        match (self.level, self.lost) {
            (_, Some(reason)) => loss(reason),
            (Some(true), None) => "1",
            (Some(false), None) => "0",
            (None, None) => "-",
        }
    }
}

/// Why a device is gone, in a word.
pub fn loss(reason: LossReason) -> &'static str {
    match reason {
        LossReason::Injected | LossReason::Gone => "gone",
        LossReason::Unresponsive => "unresponsive",
    }
}

/// A quantity in the unit of its channel.
pub fn quantity(quantity: AnalogQuantity, unit: &str) -> String {
    match quantity {
        AnalogQuantity::Is(Value::Real(number)) => format!("{number:.4} {unit}").trim_end().to_owned(),
        AnalogQuantity::Is(Value::Unknown) => "not known".to_owned(),
        AnalogQuantity::Is(value) => format!("{value} {unit}").trim_end().to_owned(),
        AnalogQuantity::NotKnown(gap) => format!("not known: {gap}"),
    }
}

/// A table of channels and what happened on them; times count from the first look.
pub fn table(channels: &[Channel], tallies: &[ChannelActivity]) -> String {
    let wide = channels.iter().map(|channel| channel.name.len()).max().unwrap_or(0).max("channel".len());
    let mut text =
        format!("{:<wide$}  {:>12} {:>9} {:>9}  {}\n", "channel", "level", "rises", "falls", "last change");
    for (channel, tally) in channels.iter().zip(tallies) {
        text.push_str(&format!("{}\n", row(channel, tally, wide)));
    }
    text
}

/// A row of the table whose first column is so wide.
pub fn row(channel: &Channel, tally: &ChannelActivity, wide: usize) -> String {
    let last = tally.last.map_or_else(|| "-".to_owned(), |last| super::real_board_file::seconds(last.latest));
    let missed = match tally.dropped {
        0 => String::new(),
        count => format!("  {count} missed"),
    };
    let (name, level, rises, falls) = (&channel.name, tally.word(), tally.rises, tally.falls);
    if !channel.is_digital() {
        let unit = channel.unit();
        let shown = match tally.quantity {
            Some(shown) if tally.lost.is_none() => quantity(shown, unit),
            _ => level.to_owned(),
        };
        let noise = match tally.noise {
            Some(noise) => format!("  noise {noise:.1e} {unit}").trim_end().to_owned(),
            None => String::new(),
        };
        return format!("{name:<wide$}  {shown:>26}  {last}{missed}{noise}");
    }
    format!("{name:<wide$}  {level:>12} {rises:>9} {falls:>9}  {last}{missed}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use drivers::ChannelId;
    use signal::Time;

    #[test]
    fn a_quantity_says_how_far_it_is_known_or_why_it_is_not() {
        let event = |value, origin| BoardEvent::Changed {
            channel: ChannelId(0),
            at: When::exactly(Time::ZERO),
            value,
            origin,
        };
        let mut tally = ChannelActivity::default();
        let mut shown = |value, origin| match tally.take(&event(value, origin)) {
            ActivityChange::Quantity(now) => quantity(now, "bar"),
            other => panic!("{other:?}"),
        };
        assert_eq!(shown(Value::measured(3.3, 0.012), Origin::Outside), "3.300 ± 0.012 bar");
        assert_eq!(shown(Value::Real(3.3), Origin::Outside), "3.3000 bar");
        assert_eq!(shown(Value::Unknown, Origin::Gap(SignalGap::OpenWire)), "not known: its wire is open");
    }

    #[test]
    fn a_first_level_is_no_change_and_neither_is_one_after_a_loss() {
        let channel = ChannelId(0);
        let at = |ms: i64| Time::from_nanos(ms * 1_000_000);
        let changed = |ms, level| BoardEvent::Changed {
            channel,
            at: When::exactly(at(ms)),
            value: Value::Bool(level),
            origin: Origin::Outside,
        };
        let mut tally = ChannelActivity::default();
        assert_eq!((tally.word(), tally.take(&changed(0, true))), ("-", ActivityChange::First(true)));
        assert_eq!(tally.take(&changed(1, false)), ActivityChange::Change(false, When::exactly(at(1))));
        assert_eq!(
            tally.take(&BoardEvent::Dropped { channel, at: at(2), count: 3 }),
            ActivityChange::Dropped(3)
        );
        let reason = LossReason::Unresponsive;
        assert_eq!(
            tally.take(&BoardEvent::Lost { channel, at: at(3), reason }),
            ActivityChange::Lost(reason)
        );
        assert_eq!(tally.word(), "unresponsive");
        assert_eq!(tally.take(&BoardEvent::Returned { channel, at: at(4) }), ActivityChange::Returned);
        assert_eq!(tally.take(&changed(4, true)), ActivityChange::First(true));
        assert_eq!((tally.rises, tally.falls, tally.dropped, tally.word()), (0, 1, 3, "1"));
    }
}
