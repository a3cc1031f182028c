//! A frequency over time as straight pieces, the band around it, and how many pulses lie under its borders.

/// Farthest instant, nanoseconds: 52 days.
const FAR: f64 = 4_503_599_627_370_496.0;

/// A straight piece: from an instant and frequency to another. Instants are nanoseconds after the shape's beginning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapePiece {
    /// When it begins.
    pub from: f64,
    /// When it ends, later than it begins.
    pub until: f64,
    /// The frequency at its beginning, hertz; below 0 backwards.
    pub first: f64,
    /// The frequency at its end.
    pub last: f64,
}

impl ShapePiece {
    fn at(&self, t: f64) -> f64 {
        self.first + (self.last - self.first) * ((t - self.from) / (self.until - self.from))
    }
}

/// A frequency over time. It is 0 before its beginning, and after its last piece it stays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrequencyShape {
    pieces: Vec<ShapePiece>,
}

impl FrequencyShape {
    /// Adds a piece of this length after the others; one without length is a jump.
    pub fn go(&mut self, length: f64, first: f64, last: f64) {
        let from = self.pieces.last().map_or(0.0, |piece| piece.until);
        if self.pieces.is_empty() {
            self.pieces.push(ShapePiece { from: -FAR, until: 0.0, first: 0.0, last: 0.0 });
        }
        let from = from.max(0.0);
        if length > 0.0 {
            self.pieces.push(ShapePiece { from, until: from + length, first, last });
        }
    }

    /// Closes it: from here on the frequency stays.
    #[must_use]
    pub fn stay(mut self, frequency: f64) -> FrequencyShape {
        self.go(FAR, frequency, frequency);
        self
    }

    /// The highest frequency in either direction.
    pub fn highest(&self) -> f64 {
        self.pieces.iter().flat_map(|piece| [piece.first.abs(), piece.last.abs()]).fold(0.0, f64::max)
    }

    /// Whether it goes backwards anywhere.
    pub fn turns(&self) -> bool {
        self.pieces.iter().any(|piece| piece.first < 0.0 || piece.last < 0.0)
    }

    /// The band that a pulse train may keep to whose instants are off by up to `reach` nanoseconds: at each instant the
    /// least and the greatest frequency within reach. With a reach below 0, the narrower band that lies within it
    /// however the whole shape is shifted by up to that much.
    pub fn band(&self, reach: f64) -> ShapeBand {
        let low = filtered(&self.pieces, reach.abs(), reach >= 0.0);
        let high = filtered(&self.pieces, reach.abs(), reach < 0.0);
        ShapeBand { low, high }
    }
}

/// The borders of what a pulse train may do.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeBand {
    low: Vec<ShapePiece>,
    high: Vec<ShapePiece>,
}

/// A border of the band, seen in a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BandBorder {
    /// Pulses that have to come.
    Least,
    /// Pulses that may come.
    Most,
}

impl ShapeBand {
    /// Pulses under a border from one instant to another, and how many more or fewer they become with a hertz of
    /// tolerance. After the end there are none.
    pub fn pulses(
        &self,
        border: BandBorder,
        backwards: bool,
        tolerance: f64,
        (from, until): (f64, f64),
    ) -> (f64, f64) {
        let pieces = if (border == BandBorder::Least) == backwards { &self.high } else { &self.low };
        let sign = if backwards { -1.0 } else { 1.0 };
        let shift = if border == BandBorder::Least { -tolerance } else { tolerance };
        let (mut pulses, mut slope) = (0.0, 0.0);
        let begin = pieces.partition_point(|piece| piece.until <= from);
        for piece in pieces.iter().skip(begin) {
            let (left, right) = (piece.from.max(from), piece.until.min(until));
            if left >= right {
                break;
            }
            let (area, time) =
                above(sign * piece.at(left) + shift, sign * piece.at(right) + shift, right - left);
            (pulses, slope) = (pulses + area, slope + time);
        }
        // Nanoseconds to seconds.
        (pulses * 1e-9, slope * 1e-9)
    }
}

/// What of a straight line from `first` to `last` over a time lies above 0: the area under it, and for how long.
fn above(first: f64, last: f64, time: f64) -> (f64, f64) {
    match (first > 0.0, last > 0.0) {
        (true, true) => ((first + last) / 2.0 * time, time),
        (false, false) => (0.0, 0.0),
        (rises_not, _) => {
            let (high, low) = if rises_not { (first, last) } else { (last, first) };
            let part = time * high / (high - low);
            (high / 2.0 * part, part)
        }
    }
}

/// At each instant the least (or greatest) of the values within `reach` of it.
fn filtered(pieces: &[ShapePiece], reach: f64, least: bool) -> Vec<ShapePiece> {
    if reach == 0.0 || pieces.is_empty() {
        return pieces.to_vec();
    }
    let pick = |a: f64, b: f64| if least { a.min(b) } else { a.max(b) };
    // Between two of these instants both ends of the reach run along one piece each.
    let inner = || pieces.iter().skip(1).map(|piece| piece.from);
    let mut cuts: Vec<f64> = inner().map(|at| at - reach).chain(inner().map(|at| at + reach)).collect();
    cuts.extend([-FAR, FAR]);
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let mut out: Vec<ShapePiece> = Vec::with_capacity(cuts.len() * 2);
    for pair in cuts.windows(2) {
        let (from, until) = (pair[0], pair[1]);
        let middle = from.midpoint(until);
        let place = |at: f64| pieces.partition_point(|piece| piece.until <= at).min(pieces.len() - 1);
        let (left, right) = (place(middle - reach), place(middle + reach));
        // What lies in between is within reach all along.
        let ends = pieces[left..right].iter().map(|piece| piece.last);
        let begins = pieces[left..right].iter().skip(1).chain((left < right).then(|| &pieces[right]));
        let between = ends.chain(begins.map(|piece| piece.first)).reduce(pick);
        let lines: [(f64, f64); 3] = [
            (pieces[left].at(from - reach), pieces[left].at(until - reach)),
            (pieces[right].at(from + reach), pieces[right].at(until + reach)),
            between.map_or((pieces[left].at(from - reach), pieces[left].at(until - reach)), |one| (one, one)),
        ];
        bent(&mut out, (from, until), &lines, pick);
    }
    out
}

/// The least (or greatest) of three straight lines between two instants, piece by piece.
fn bent(
    out: &mut Vec<ShapePiece>,
    (from, until): (f64, f64),
    lines: &[(f64, f64); 3],
    pick: impl Fn(f64, f64) -> f64,
) {
    let mut parts = vec![0.0, 1.0];
    for (at, one) in lines.iter().enumerate() {
        for other in &lines[at + 1..] {
            let (first, last) = (one.0 - other.0, one.1 - other.1);
            let part = first / (first - last);
            if part > 0.0 && part < 1.0 {
                parts.push(part);
            }
        }
    }
    parts.sort_by(f64::total_cmp);
    let value = |part: f64| {
        let at = |line: &(f64, f64)| line.0 + (line.1 - line.0) * part;
        pick(pick(at(&lines[0]), at(&lines[1])), at(&lines[2]))
    };
    for pair in parts.windows(2) {
        let instant = |part: f64| from + (until - from) * part;
        let (begin, end) = (instant(pair[0]), instant(pair[1]));
        if begin < end {
            out.push(ShapePiece { from: begin, until: end, first: value(pair[0]), last: value(pair[1]) });
        }
    }
}
