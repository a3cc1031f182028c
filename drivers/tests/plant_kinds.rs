//! Plants of every kind, as board files have them, against what their laws give.

use crate::common::*;
use document::SourceFile;
use scanrig_drivers::{Board, BoardFile, Subject, Terminals, UnknownSubject, build, read};
use signal::{Address, Value};

fn terminals(_: &Subject) -> Result<Terminals, UnknownSubject> {
    let addresses =
        |area: &str| (0..8).map(|bit| Address::parse(&format!("%{area}X0.{bit}")).unwrap()).collect();
    Ok(Terminals { inputs: addresses("I"), outputs: addresses("Q"), ports: Vec::new(), modules: Vec::new() })
}

struct Bench {
    file: BoardFile,
    board: Box<dyn Board>,
}

impl Bench {
    /// A started board with these channels and plants.
    fn new(text: &str) -> Bench {
        let text = format!("format = 1\n{text}");
        let file =
            read(&SourceFile::new("b.toml", text), &terminals).unwrap_or_else(|found| panic!("{found:#?}"));
        let mut board = build(&file, 7).unwrap();
        board.start(at(0)).unwrap();
        poll(&mut *board, 0);
        Bench { file, board }
    }

    fn write(&mut self, seconds: f64, name: &str, value: Value) {
        let channel = self.file.find(name).unwrap();
        self.board.write(at((seconds * 1e9) as i64), &[(channel, value)]).unwrap();
    }

    /// What a channel changes to up to an instant.
    fn until(&mut self, seconds: f64, name: &str) -> Vec<(i64, Value)> {
        let channel = self.file.find(name).unwrap();
        changes(&poll(&mut *self.board, (seconds * 1e9) as i64), channel.0)
    }
}

#[test]
fn a_damped_response_overshoots_and_a_heater_does_not() {
    let text = |kind: &str, more: &str| {
        format!(
            "channels = {{ y = {{ kind = \"analog\", unit = \"degC\" }} }}\n[[plants]]\nkind = \"{kind}\"\nname = \"p\"\n\
             input = \"Q0\"\noutput = \"y\"\nsample = \"10 ms\"\ntau = \"1 s\"\n{more}\n"
        )
    };
    let peak = |text: &str| {
        let mut bench = Bench::new(text);
        bench.write(0.0, "Q0", ON);
        let values = bench.until(100.0, "y");
        values.iter().map(|(_, value)| value.as_real().unwrap()).fold(0.0, f64::max)
    };
    let overshoot = peak(&text("second-order", "damping = 0.5\nlow = 0\nhigh = 100"));
    let exact = 100.0 + 100.0 * f64::exp(-0.5 * std::f64::consts::PI / 0.75f64.sqrt());
    assert!((overshoot - exact).abs() < 0.01, "{overshoot} {exact}");
    let heated = peak(&text("heater", "sensor-tau = \"200 ms\"\nambient = 20\nrise = 60"));
    assert!((79.99..=80.0).contains(&heated), "{heated}");
}
