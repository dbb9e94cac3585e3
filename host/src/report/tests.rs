use std::sync::LazyLock;

use motorlens_virtual_motor::{Effect, Motor};

use super::*;
use crate::compare::free_run::pooled;
use crate::diagnose::discover::{Options, discover};
use crate::findings::Findings;
use crate::fit::uncertainty::Estimate;
use crate::log::Warning;
use crate::motor_file::MotorFile;
use crate::simulate::{Excitation, Role, Scenario, plays};
use motorlens_shared::effects::Kind;

/// A discovery on the default protocol with dry friction, told once for all tests.
static STORY: LazyLock<Story> = LazyLock::new(|| {
    let motor = Motor::paper();
    let effects = vec![Effect::parse("coulomb=0.4").unwrap()];
    let plays = plays(Excitation::Default, 9.0, 12.0, None, 1);
    let all = Scenario::new(motor, effects, 1).records(&plays).unwrap();
    let (unseen, fitted): (Vec<_>, Vec<_>) =
        plays.iter().zip(all).partition(|(play, _)| play.role == Role::HeldOut);
    let of = |pairs: Vec<(_, crate::log::Record)>| pairs.into_iter().map(|(_, r)| r).collect::<Vec<_>>();
    let (fitted, unseen) = (of(fitted), of(unseen));
    let options = Options { library: vec![Kind::Coulomb, Kind::Gravity, Kind::DeadZone], most: 2 };
    let found = discover(&fitted, &unseen, &MotorFile::default(), &options, &mut |_| ()).unwrap();
    let faults = vec![Warning {
        place: "a.csv, column angle_rad".into(),
        what: "stale_samples: old".into(),
        fix: "read it anew".into(),
    }];
    Story::of(&found, &Findings::new(&found, &faults), &fitted)
});

#[test]
fn table_and_ladder_tell_one_error_of_records_that_begin_in_motion() {
    let plays = plays(Excitation::Default, 3.0, 12.0, None, 1);
    let effects = vec![Effect::parse("coulomb=0.4").unwrap()];
    let mut records = Scenario::new(Motor::paper(), effects, 1).records(&plays[..2]).unwrap();
    for record in &mut records {
        let from = record.len() / 4;
        record.time_s.drain(..from);
        record.voltage_v.drain(..from);
        record.angle_rad.as_mut().unwrap().drain(..from);
    }
    let options = Options { library: vec![Kind::Coulomb], most: 1 };
    let found = discover(&records, &[], &MotorFile::default(), &options, &mut |_| ()).unwrap();
    let story = Story::of(&found, &Findings::new(&found, &[]), &records);
    let (bases, models): (Vec<_>, Vec<_>) =
        story.records.iter().map(|s| (s.base.clone(), s.model.clone())).unzip();
    let [base, model] = [bases, models].map(|runs| pooled(&runs).unwrap().rmse);
    let [first, last] = [&found.ladder[0], found.ladder.last().unwrap()].map(|rung| rung.train.rmse);
    assert!(
        (base / first - 1.0).abs() < 1e-9 && (model / last - 1.0).abs() < 1e-9,
        "{base} {first} {model} {last}"
    );
}

#[test]
fn a_report_of_the_default_protocol_needs_no_network_and_less_than_6_megabytes() {
    let page = html(&STORY).unwrap();
    assert!(page.len() < 6_000_000, "{} bytes", page.len());
    let without_library = page.replace(LIBRARY, "");
    for asks in ["src=\"http", "href=\"http", "url(", "@import", "fetch("] {
        assert!(!without_library.contains(asks), "{asks}");
    }
    assert!(page.contains("uPlot"));
}

#[test]
fn the_steps_come_in_the_order_of_the_work() {
    let page = html(&STORY).unwrap();
    let places: Vec<usize> = ["data-faults", "compare", "fails", "missing", "add", "falls"]
        .iter()
        .map(|id| page.find(&format!("section id=\"{id}\"")).expect(id))
        .collect();
    assert!(places.is_sorted());
    let fault = page.find("stale samples").expect("told before any physics");
    assert!(places[0] < fault && fault < places[1]);
    let ids: Vec<&str> = page.split(" id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    let twice = ids.iter().find(|id| ids.iter().filter(|other| other == id).count() > 1);
    assert_eq!(twice, None, "the scripts find things by their ids");
    assert!(page.contains("validation") && page.contains("dry (Coulomb) friction"));
}

#[test]
fn data_in_the_page_cannot_end_its_script() {
    let mut story = STORY.clone();
    story.records[0].model.record = "</script><b>".into();
    let page = html(&story).unwrap();
    assert!(!page.contains("</script><b>"));
}

#[test]
fn friction_shows_as_the_side_that_explains_most_and_goes_when_added() {
    let share = |torques: &Torques| fails::Side::Speed.binned(torques, STORY.model.rig.gear_ratio);
    let (before, after) = (share(&STORY.base_torques), share(&STORY.model_torques));
    let swing = |b: &crate::compare::residual_views::Binned| {
        b.mean_v.iter().copied().fold(f64::MIN, f64::max) - b.mean_v.iter().copied().fold(f64::MAX, f64::min)
    };
    assert!(swing(&after) < 0.3 * swing(&before), "{} {}", swing(&after), swing(&before));
}

#[test]
fn the_accepted_effect_and_the_best_of_the_others_are_shown_over_the_records() {
    let (all, cards) = figures(&STORY);
    let drawn = cards.iter().filter(|card| !card.figures.is_empty()).count();
    assert!(drawn >= DRAWN.min(cards.len()), "{drawn} of {}", cards.len());
    let accepted = cards.iter().find(|card| card.added).unwrap();
    let figure = all.missing.iter().find(|f| f.id == accepted.figures[0]).unwrap();
    assert_eq!(figure.panels[0].curves[1].name, "equation of coulomb");
    assert!(
        figure.title.contains("by speed") && figure.reading.contains("the dots follow it"),
        "{}",
        figure.reading
    );
}

#[test]
fn every_axis_has_a_title_with_its_unit() {
    let (all, _) = figures(&STORY);
    let figures = [all.compare, all.fails, all.missing].concat();
    for figure in &figures {
        for title in figure.panels.iter().map(|panel| &panel.y.title).chain([&figure.x.title]) {
            assert!(title.contains('(') && title.ends_with(')'), "{}: {title}", figure.id);
        }
    }
}

#[test]
fn an_interval_that_the_records_leave_open_says_so_and_has_no_ends() {
    let mut story = STORY.clone();
    let open = Estimate {
        name: "gain".into(),
        value: 1.4,
        unit: "1".into(),
        low: 1.25e-32,
        high: 3.5e38,
        identifiable: false,
    };
    let known =
        Estimate { name: "tau_m".into(), low: 1.2, high: 205_799_999.9, identifiable: true, ..open.clone() };
    story.parameters = vec![open, known];
    let page = html(&story).unwrap();
    let parameters = page.split("<caption>Parameters</caption>").nth(1).unwrap();
    let rows = parameters.split("</table>").next().unwrap();
    assert!(rows.contains("<td>not determined</td><td></td>"), "{rows}");
    assert!(!rows.contains("e-32") && !rows.contains("000000000"), "{rows}");
    assert!(rows.contains("<td>1.2 … 205800000</td>"), "{rows}");
}
