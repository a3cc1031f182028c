//! What is counted, by counters of the kernel and by modelled ones.

/// The edge of its first signal that a counter of single pulses counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CountEdge {
    /// From 0 to 1.
    Rising,
    /// From 1 to 0.
    Falling,
    /// Each.
    Both,
}

impl CountEdge {
    /// As the kernel writes it.
    pub const fn kernel(self) -> &'static str {
        match self {
            CountEdge::Rising => "rising edge",
            CountEdge::Falling => "falling edge",
            CountEdge::Both => "both edges",
        }
    }
}

/// What is made of the signals of a count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CountFunction {
    /// Pulses on A count up.
    Increase,
    /// Pulses on A count down.
    Decrease,
    /// Pulses on A count, B says which way.
    PulseDirection,
    /// One count for each period of A and B.
    QuadratureX1,
    /// The same, by the edges of B.
    QuadratureX1B,
    /// A count for each edge of A.
    QuadratureX2,
    /// A count for each edge of B.
    QuadratureX2B,
    /// A count for each edge of either.
    QuadratureX4,
}

impl CountFunction {
    /// All with their names in a board file and in the kernel.
    pub const ALL: [(CountFunction, &'static str, &'static str); 8] = [
        (CountFunction::Increase, "increase", "increase"),
        (CountFunction::Decrease, "decrease", "decrease"),
        (CountFunction::PulseDirection, "pulse-direction", "pulse-direction"),
        (CountFunction::QuadratureX1, "quadrature-x1", "quadrature x1 a"),
        (CountFunction::QuadratureX1B, "quadrature-x1-b", "quadrature x1 b"),
        (CountFunction::QuadratureX2, "quadrature-x2", "quadrature x2 a"),
        (CountFunction::QuadratureX2B, "quadrature-x2-b", "quadrature x2 b"),
        (CountFunction::QuadratureX4, "quadrature-x4", "quadrature x4"),
    ];

    /// Its name in a board file.
    pub fn name(self) -> &'static str {
        self.names().0
    }

    /// Its name in the kernel.
    pub fn kernel(self) -> &'static str {
        self.names().1
    }

    fn names(self) -> (&'static str, &'static str) {
        let own = CountFunction::ALL.iter().find(|(function, ..)| *function == self);
        own.map_or(("", ""), |(_, name, kernel)| (name, kernel))
    }

    /// The function of this name in a board file.
    pub fn named(name: &str) -> Option<CountFunction> {
        CountFunction::ALL.iter().find(|(_, known, _)| *known == name).map(|(function, ..)| *function)
    }
}
