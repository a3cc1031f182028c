//! The reference functions of thermocouples on the international temperature scale of 1990 (IEC 60584-1; NIST Monograph 175), in
//! millivolts with the reference junction at 0 °C.

/// A part of a reference function.
#[derive(Debug, PartialEq)]
pub(super) struct Piece {
    /// From this temperature on, in degrees Celsius.
    pub(super) from: f64,
    /// To this one.
    pub(super) to: f64,
    /// The polynomial, from its highest power down.
    powers: &'static [f64],
    /// `a`, `b` and `c` of `a * exp(b * (t - c)^2)`, which type K has too.
    exponential: Option<(f64, f64, f64)>,
}

impl Piece {
    /// The voltage at a temperature.
    pub(super) fn millivolts(&self, celsius: f64) -> f64 {
        let sum = self.powers.iter().fold(0.0, |sum, factor| sum * celsius + factor);
        let exponential = |(a, b, c): (f64, f64, f64)| a * libm::exp(b * (celsius - c) * (celsius - c));
        sum + self.exponential.map_or(0.0, exponential)
    }
}

/// The types by their letters. Type B begins where it rises: below 21 °C it has no voltage to speak of.
pub(super) const COUPLES: &[(&str, &[Piece])] = &[
    (
        "B",
        &[
            Piece {
                from: 22.0,
                to: 630.615,
                powers: &[
                    6.2990347094e-19,
                    -1.694452924e-15,
                    1.5668291901e-12,
                    -1.3257931636e-9,
                    5.9040421171e-6,
                    -2.4650818346e-4,
                    0.0,
                ],
                exponential: None,
            },
            Piece {
                from: 630.615,
                to: 1820.0,
                powers: &[
                    -9.3791330289e-25,
                    9.8975640821e-21,
                    -4.4515431033e-17,
                    1.1109794013e-13,
                    -1.6835344864e-10,
                    1.5785280164e-7,
                    -8.4885104785e-5,
                    2.857174747e-2,
                    -3.8938168621e0,
                ],
                exponential: None,
            },
        ],
    ),
    (
        "E",
        &[
            Piece {
                from: -270.0,
                to: 0.0,
                powers: &[
                    -3.4657842013e-29,
                    -5.5827328721e-26,
                    -3.9673619516e-23,
                    -1.6414776355e-20,
                    -4.3979497391e-18,
                    -8.0370123621e-16,
                    -1.0287605534e-13,
                    -9.3214058667e-12,
                    -5.9452583057e-10,
                    -2.5800160843e-8,
                    -7.7998048686e-7,
                    4.5410977124e-5,
                    5.8665508708e-2,
                    0.0,
                ],
                exponential: None,
            },
            Piece {
                from: 0.0,
                to: 1000.0,
                powers: &[
                    3.5960899481e-28,
                    -1.4388041782e-24,
                    2.1489217569e-21,
                    -1.2536600497e-18,
                    -1.9197495504e-16,
                    6.502440327e-13,
                    -3.3056896652e-10,
                    2.8908407212e-8,
                    4.5032275582e-5,
                    5.866550871e-2,
                    0.0,
                ],
                exponential: None,
            },
        ],
    ),
    (
        "J",
        &[
            Piece {
                from: -210.0,
                to: 760.0,
                powers: &[
                    1.5631725697e-23,
                    -1.2538395336e-19,
                    2.0948090697e-16,
                    -1.7052958337e-13,
                    1.3228195295e-10,
                    -8.568106572e-8,
                    3.047583693e-5,
                    5.0381187815e-2,
                    0.0,
                ],
                exponential: None,
            },
            Piece {
                from: 760.0,
                to: 1200.0,
                powers: &[
                    -3.0691369056e-13,
                    1.5720819004e-9,
                    -3.1847686701e-6,
                    3.1787103924e-3,
                    -1.4976127786e0,
                    2.9645625681e2,
                ],
                exponential: None,
            },
        ],
    ),
    (
        "K",
        &[
            Piece {
                from: -270.0,
                to: 0.0,
                powers: &[
                    -1.6322697486e-23,
                    -1.9889266878e-20,
                    -1.0451609365e-17,
                    -3.1088872894e-15,
                    -5.7410327428e-13,
                    -6.7509059173e-11,
                    -4.9904828777e-9,
                    -3.2858906784e-7,
                    2.3622373598e-5,
                    3.9450128025e-2,
                    0.0,
                ],
                exponential: None,
            },
            Piece {
                from: 0.0,
                to: 1372.0,
                powers: &[
                    -1.2104721275e-26,
                    9.7151147152e-23,
                    -3.2020720003e-19,
                    5.6075059059e-16,
                    -5.6072844889e-13,
                    3.1840945719e-10,
                    -9.9457592874e-8,
                    1.8558770032e-5,
                    3.8921204975e-2,
                    -1.7600413686e-2,
                ],
                exponential: Some((1.185976e-1, -1.183432e-4, 1.269686e2)),
            },
        ],
    ),
    (
        "N",
        &[
            Piece {
                from: -270.0,
                to: 0.0,
                powers: &[
                    -9.3419667835e-20,
                    -7.6089300791e-17,
                    -2.2653438003e-14,
                    -2.6303357716e-12,
                    -4.6412039759e-11,
                    -9.3841111554e-8,
                    1.0957484228e-5,
                    2.6159105962e-2,
                    0.0,
                ],
                exponential: None,
            },
            Piece {
                from: 0.0,
                to: 1300.0,
                powers: &[
                    -3.0682196151e-29,
                    2.0849229339e-25,
                    -6.0863245607e-22,
                    9.9745338992e-19,
                    -1.0063471519e-15,
                    6.4311819339e-13,
                    -2.5261169794e-10,
                    4.3825627237e-8,
                    1.571014188e-5,
                    2.5929394601e-2,
                    0.0,
                ],
                exponential: None,
            },
        ],
    ),
    (
        "R",
        &[
            Piece {
                from: -50.0,
                to: 1064.18,
                powers: &[
                    -2.81038625251e-27,
                    1.57716482367e-23,
                    -3.73105886191e-20,
                    5.00777441034e-17,
                    -4.62347666298e-14,
                    3.56916001063e-11,
                    -2.38855693017e-8,
                    1.39166589782e-5,
                    5.28961729765e-3,
                    0.0,
                ],
                exponential: None,
            },
            Piece {
                from: 1064.18,
                to: 1664.5,
                powers: &[
                    -2.93359668173e-16,
                    2.05305291024e-12,
                    -7.64085947576e-9,
                    1.59564501865e-5,
                    -2.52061251332e-3,
                    2.95157925316e0,
                ],
                exponential: None,
            },
            Piece {
                from: 1664.5,
                to: 1768.1,
                powers: &[
                    -9.34633971046e-15,
                    -3.45895706453e-8,
                    1.71280280471e-4,
                    -2.68819888545e-1,
                    1.52232118209e2,
                ],
                exponential: None,
            },
        ],
    ),
    (
        "S",
        &[
            Piece {
                from: -50.0,
                to: 1064.18,
                powers: &[
                    2.71443176145e-24,
                    -1.25068871393e-20,
                    2.55744251786e-17,
                    -3.31465196389e-14,
                    3.22028823036e-11,
                    -2.32477968689e-8,
                    1.2593428974e-5,
                    5.40313308631e-3,
                    0.0,
                ],
                exponential: None,
            },
            Piece {
                from: 1064.18,
                to: 1664.5,
                powers: &[
                    1.29989605174e-14,
                    -1.64856259209e-9,
                    6.54805192818e-6,
                    3.34509311344e-3,
                    1.32900444085e0,
                ],
                exponential: None,
            },
            Piece {
                from: 1664.5,
                to: 1768.1,
                powers: &[
                    -9.43223690612e-15,
                    -3.30439046987e-8,
                    1.63693574641e-4,
                    -2.58430516752e-1,
                    1.46628232636e2,
                ],
                exponential: None,
            },
        ],
    ),
    (
        "T",
        &[
            Piece {
                from: -270.0,
                to: 0.0,
                powers: &[
                    7.9795153927e-31,
                    1.3945027062e-27,
                    1.079553927e-24,
                    4.8768662286e-22,
                    1.4251594779e-19,
                    2.8213521925e-17,
                    3.8493939883e-15,
                    3.6071154205e-13,
                    2.2651156593e-11,
                    9.0138019559e-10,
                    2.0032973554e-8,
                    1.1844323105e-7,
                    4.4194434347e-5,
                    3.8748106364e-2,
                    0.0,
                ],
                exponential: None,
            },
            Piece {
                from: 0.0,
                to: 400.0,
                powers: &[
                    -2.7512901673e-20,
                    4.547913529e-17,
                    -3.0815758772e-14,
                    1.0996880928e-11,
                    -2.1882256846e-9,
                    2.0618243404e-7,
                    3.329222788e-5,
                    3.8748106364e-2,
                    0.0,
                ],
                exponential: None,
            },
        ],
    ),
];
