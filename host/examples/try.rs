use motorlens::fit::{setup, cost::Objective};
use motorlens::log::{ReadArgs, load};
use clap::Parser;
#[derive(Parser)]
struct A { logs: Vec<std::path::PathBuf>, #[command(flatten)] read: ReadArgs }
fn main() {
    let a = A::parse();
    let recs = load(&a.logs, &a.read).unwrap();
    let (p, start) = setup::problem(&recs, &a.read.motor_file().unwrap());
    for g in &p.grids { println!("{} n {} step {} cells {} {:?} q {} w0 {}", g.name, g.len(), g.step_s, g.voltages.len(), g.quantity, g.quantum, g.start_speed); }
    println!("sigma {} start {:?} rig {:?}", p.sigma, start, p.rig);
    let t = std::time::Instant::now();
    let (l, x) = p.fit_base(&start);
    let c = p.search(&l, Objective::Increments, &x, 1, 1e-9);
    println!("{:?} rms {} sims {} {:?}", l.unpack(&x).base, (c.cost / c.count as f64).sqrt(), p.simulations.get(), t.elapsed());
}
