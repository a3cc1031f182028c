//! A rig on the host's clock: nobody asks for its time.

use super::with_rig;
use services::control::{RigEvent, RigOrder};
use signal::{Span, Value};

#[test]
fn it_runs_by_itself_and_orders_come_between_two_turns() {
    let played = with_rig(false, |bench| {
        let count = bench.watch("MAIN.count");
        bench.until("a third change", |reported| match reported {
            RigEvent::Change { signal, value: Value::Int(n), .. } if *signal == count && *n > 2 => Some(()),
            _ => None,
        });
        bench.status("a cycle", |status| status.tasks[0].cycles > 2 && status.state == "RUNNING");
        bench.write("start", Value::Bool(true)).unwrap();
        let signal = bench.watch("signal");
        bench.until("the lamp", |reported| match reported {
            RigEvent::Change { signal: of, value: Value::Bool(true), .. } if *of == signal => Some(()),
            _ => None,
        });
        let fault = bench.order(RigOrder::Advance(Span::from_millis(1))).unwrap_err();
        assert_eq!(fault.code, "R0607");
    });
    assert_eq!(played.fault, None);
}
