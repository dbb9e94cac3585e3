use motorlens::diagnose::{candidate::Evidence, climb};
use motorlens::exam::case::{Case, Conditions};
use motorlens::fit::{grid::Grid, setup};
use motorlens_shared::effects::Kind;
use motorlens_virtual_motor::Kind as P;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let from: u64 = a[1].parse().unwrap();
    let n: u64 = a[2].parse().unwrap();
    let only = a.get(3).cloned().unwrap_or_default();
    let cond = Conditions { disturbed: a.get(4).map_or(0.0, |x| x.parse().unwrap()), spoilt: a.get(5).map_or(0.0, |x| x.parse().unwrap()) };
    let mut list: Vec<Vec<P>> = P::all().map(|k| vec![k]).collect();
    list.push(vec![]);
    let (mut right, mut first, mut two, mut total, mut time) = (0, 0, 0, 0, 0.0);
    for rep in 0..n {
        for (i, kinds) in list.iter().enumerate() {
            let name = kinds.first().map_or("none", |k| k.row().name);
            if !only.is_empty() && !only.split(',').any(|o| o == name) { continue }
            let case = Case::new(from + rep * 100 + i as u64, kinds, cond);
            let t = std::time::Instant::now();
            let (p, start) = setup::problem(&case.records, &case.motor);
            let (q, _) = setup::problem(&case.held_out, &case.motor);
            let unseen = p.on(q.grids);
            let e = Evidence { train: p, unseen };
            let (layout, x) = e.train.fit_base(&start);
            let base = e.fit(&layout.unpack(&x), 2);
            let c = climb::run(&e, base, Kind::ALL, 3, &mut |_, _| {}, &mut |_| {});
            let s = t.elapsed().as_secs_f64(); time += s;
            let found: Vec<&str> = c.model().kinds().iter().map(|k| k.name()).collect();
            let mut sorted = found.clone(); sorted.sort();
            let mut truth = case.truth.clone(); truth.sort();
            let top: Vec<String> = c.first.iter().take(4).map(|c| format!("{}[{:.2} {:.2} {:.1} {:.1}]", c.kinds()[0], c.train.increments, c.unseen.increments, c.train.position, c.unseen.position)).collect();
            total += 1;
            if sorted == truth { right += 1 }
            let f1 = climb::simplest(&c.first).map(|c| c.kinds()[0].name());
            if kinds.is_empty() || f1 == Some(name) { first += 1 }
            if kinds.is_empty() || c.first.iter().take(2).any(|c| c.kinds()[0].name() == name) { two += 1 }
            let sig = e.train.sigma;
            println!("{} {} {} -> {:?} base[{:.2} {:.2} {:.1}] end[{:.2} {:.2} {:.1} {:.1}] floor {:.2} {:.1}s {} | {} | {}", if sorted == truth {"ok  "} else {"MISS"}, name, case.sizes, found,
                c.rungs[0].train.increments, c.rungs[0].unseen.increments, c.rungs[0].unseen.position,
                c.model().train.increments, c.model().unseen.increments, c.model().train.position, c.model().unseen.position, case.floor_rad / sig, s, e.simulations(), case.conditions, top.join(" "));
        }
    }
    println!("right {right}/{total} first {first} two {two} mean {:.2}s", time / total as f64);
}
