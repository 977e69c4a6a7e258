//! Controllers that attach in any order, simulated.

use ambidex::model::{ControllerId, Time};
use ambidex::record::MissionReport;
use ambidex::sim::Event;
use ambidex::tree::Settings;

use crate::fixtures::{experiment_file, experiments, load, simulate};

/// Experiment 1, its controllers attaching at these moments, seconds.
fn attached_at(seconds: [u64; 4]) -> MissionReport {
    let attach = |(index, seconds)| {
        let at = Time(seconds * 1_000_000);
        (at, Event::Attach(ControllerId::from(index)))
    };
    let events = seconds.into_iter().enumerate().map(attach).collect();
    simulate(&load(&experiment_file(1)), &Settings::default(), events).1
}

fn orders() -> Vec<[u64; 4]> {
    let mut orders = vec![Vec::new()];
    for _ in 0..4 {
        let longer = |order: Vec<u64>| {
            let next = (0..4).filter(|number| !order.contains(number)).collect::<Vec<_>>();
            next.into_iter().map(move |number| [&order[..], &[number]].concat())
        };
        orders = orders.into_iter().flat_map(longer).collect();
    }
    orders.into_iter().map(|order| order.try_into().expect("four")).collect()
}

#[test]
fn the_order_in_which_controllers_attach_does_not_matter() {
    let expected = &experiments()[&1];
    let orders = orders();
    assert_eq!(orders.len(), 24);
    for order in orders {
        let report = attached_at(order);
        assert_eq!(report.outcome.word(), "done", "{order:?}");
        assert_eq!(report.steps, expected.steps, "{order:?}");
        assert_eq!(report.skipped, expected.skipped, "{order:?}");
    }
}

#[test]
fn a_late_one_only_delays_the_mission() {
    let at_once = attached_at([0; 4]);
    for late in 0..4 {
        let mut moments = [0; 4];
        moments[late] = 3600;
        let report = attached_at(moments);
        assert_eq!(report.steps, at_once.steps);
        assert_eq!(report.skipped, at_once.skipped);
        assert!((report.makespan_s - at_once.makespan_s).abs() < 0.02, "{report:?}");
    }
}

#[test]
fn a_mission_canceled_before_all_have_attached_does_not_begin() {
    let attach = |index| (Time::ZERO, Event::Attach(ControllerId(index)));
    for before in 0..4 {
        let mut events: Vec<_> = (0..4).map(attach).collect();
        events.insert(before, (Time::ZERO, Event::Cancel));
        let (_, report) = simulate(&load(&experiment_file(1)), &Settings::default(), events);
        assert_eq!((report.outcome.word(), report.rounds), ("canceled", 0), "after {before}");
    }
}
