use motorlens::exam::case::{Case, Conditions};
use motorlens::fit::{setup, cost::Objective, simulate::predict_one};
use motorlens_virtual_motor::{Motor};
fn main() {
    let seed: u64 = std::env::args().nth(1).unwrap().parse().unwrap();
    let case = Case::new(seed, &[], Conditions { disturbed: 0.0, spoilt: 0.0 });
    println!("{}", case.conditions);
    let m = Motor::hidden(seed);
    println!("true gain {} tm {} te {} vs {}", m.gain(), m.mechanical_time_constant(), m.electrical_time_constant(), m.viscous_share());
    let (p, start) = setup::problem(&case.records, &case.motor);
    println!("start {:?}", start.base);
    let (l, x) = p.fit_base(&start);
    for (o, n) in [(Objective::Increments, 20), (Objective::Increments, 40), (Objective::Position, 20)] {
        let f = p.search(&l, o, &x, n, 1e-9);
        println!("{o:?} {:?} cost {} n {}", l.unpack(&f.x).base, f.cost, f.count);
        for g in &p.grids { let q = p.on(vec![g.clone()]); println!("   {} w0 {} {:?}", g.name, g.start_speed, q.errors(&l, &f.x)); }
    }
    let truth = [m.gain(), m.mechanical_time_constant(), m.electrical_time_constant(), m.viscous_share()];
    let mut xt = x.clone(); for k in 0..3 { xt[k] = truth[k].ln() } xt[3] = truth[3];
    for g in &p.grids { let q = p.on(vec![g.clone()]); println!("truth   {} {:?}", g.name, q.errors(&l, &xt));
      let y = predict_one(&[], &truth, &p.rig, g);
      let r: Vec<String> = (0..y.len()).step_by(40).take(20).map(|k| format!("{:.2}", (g.measured[k]-y[k])/g.quantum)).collect(); println!("{}", r.join(" ")); }
}
