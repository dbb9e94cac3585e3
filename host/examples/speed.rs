use motorlens::fit::{setup, simulate::predict_block, layout::Layout};
use motorlens::log::{ReadArgs, load};
use motorlens_shared::effects::Kind;
use clap::Parser;
#[derive(Parser)]
struct A { logs: Vec<std::path::PathBuf>, #[command(flatten)] read: ReadArgs }
fn main() {
    let a = A::parse();
    let recs = load(&a.logs, &a.read).unwrap();
    let (p, start) = setup::problem(&recs, &a.read.motor_file().unwrap());
    let g = &p.grids[0];
    for kinds in [vec![], vec![Kind::Coulomb], vec![Kind::Stribeck], vec![Kind::Gravity], vec![Kind::Backlash]] {
        let l = Layout::new(&kinds, &p.rig, &p.prior);
        let mut v = start.clone();
        for k in &kinds { v = v.with(*k, k.spec().parameters.iter().map(|q| q.typical * q.scale.unit(&p.rig)).collect()); }
        let x = l.pack(&v);
        let mut out = vec![];
        let t = std::time::Instant::now();
        for _ in 0..5 { predict_block(&l, &[x.clone()], &p.rig, g, &mut out); }
        println!("{kinds:?} {:.2} ns per lane-cell", t.elapsed().as_secs_f64() * 1e9 / 5.0 / 8.0 / g.voltages.len() as f64);
    }
}
