//! explore
use crate::maps::{maps, read};
use enfilade_bake::{Cells, PairsOptions, Portal, VisiblePairs};
use enfilade_import::{PortalFile, ReadOptions, rebuild_portals_bytes, with_visibility};
use std::collections::HashMap;

type P = [f64; 3];
fn sub(a: P, b: P) -> P { [a[0]-b[0], a[1]-b[1], a[2]-b[2]] }
fn dot(a: P, b: P) -> f64 { a[0]*b[0]+a[1]*b[1]+a[2]*b[2] }
fn cross(a: P, b: P) -> P { [a[1]*b[2]-a[2]*b[1], a[2]*b[0]-a[0]*b[2], a[0]*b[1]-a[1]*b[0]] }
fn newell(c: &[P]) -> P {
    let mut n = [0.0; 3];
    for w in c[1..].windows(2) { let x = cross(sub(w[0], c[0]), sub(w[1], c[0])); for i in 0..3 { n[i] += x[i]; } }
    n
}
fn len(a: P) -> f64 { dot(a, a).sqrt() }
fn area(c: &[P]) -> f64 { if c.len() < 3 { 0.0 } else { len(newell(c)) / 2.0 } }
fn edges(c: &[P]) -> Vec<(P, P)> {
    let n = newell(c); let l = len(n); let n = n.map(|x| x / l);
    (0..c.len()).filter_map(|i| { let a = c[i]; let b = c[(i+1)%c.len()]; let e = sub(b, a); let l = len(e); if l < 1e-5 { return None; } Some((a, cross(n, e).map(|x| x / l))) }).collect()
}
/// How far the corners of `a` stick out of `b`, at most.
fn sticks(a: &[P], b: &[P]) -> f64 {
    let e = edges(b);
    a.iter().flat_map(|&p| e.iter().map(move |(o, n)| -dot(*n, sub(p, *o)))).fold(0.0, f64::max)
}
fn common(a: &[P], b: &[P]) -> Vec<P> {
    let mut poly = a.to_vec();
    for (o, n) in edges(b) {
        let mut out = vec![];
        for i in 0..poly.len() {
            let p = poly[i]; let q = poly[(i+1)%poly.len()];
            let dp = dot(n, sub(p, o)); let dq = dot(n, sub(q, o));
            if dp >= 0.0 { out.push(p); }
            if (dp >= 0.0) != (dq >= 0.0) { let t = dp/(dp-dq); out.push([0,1,2].map(|i| p[i]+(q[i]-p[i])*t)); }
        }
        poly = out;
        if poly.len() < 3 { return vec![]; }
    }
    poly
}
fn key(p: &Portal) -> [u32; 2] { let mut c = p.cells; c.sort(); c }
fn width(c: &[P]) -> f64 {
    edges(c).iter().map(|(o, n)| c.iter().map(|&p| dot(*n, sub(p, *o))).fold(0.0, f64::max)).fold(f64::INFINITY, f64::min)
}

pub(crate) fn marked(map: &[u8], given: &PortalFile) -> Vec<u8> {
    let none = Cells::new(given.cells.count(), Vec::new()).unwrap();
    let pairs = VisiblePairs::compute(&none, &PairsOptions { fast: true });
    with_visibility(map, given, &pairs).unwrap()
}

#[test]
fn explore() {
    let Some(folder) = maps() else { return };
    let only = std::env::var("ONLY").ok();
    for name in ["quake/dm1","quake/end","quake/lq_e0m1","quake/lqdm13","quake/e1m1","quake/start","quake/lq_e1m5","quake/lq_e4m4","quake3/darkzone","quake3/stormkeep","quake3/aneurysm","quake3/accident","quake3/final_rage"] {
        if only.as_ref().is_some_and(|o| !name.contains(o.as_str())) { continue }
        let given = read(&folder, &format!("{name}.prt"));
        let is_q3 = name.starts_with("quake3");
        let map = std::fs::read(folder.join(format!("{name}{}.bsp", if is_q3 { ".novis" } else { "" }))).unwrap();
        let t = std::time::Instant::now();
        let plain = rebuild_portals_bytes(&map, &ReadOptions::default()).unwrap();
        let secs = t.elapsed().as_secs_f64();
        eprintln!("== {name} given {} / {}; plain {:?} {:?} leafs {} clusters {} portals {} slivers {} in {secs:.3} s", given.cells.count(), given.cells.portals().len(), plain.clusters_from, plain.file.kind, plain.leafs, plain.file.cells.count(), plain.file.cells.portals().len(), plain.slivers);
        let ours = if is_q3 { plain } else { rebuild_portals_bytes(&marked(&map, &given), &ReadOptions::default()).unwrap() };
        eprintln!("   marked {:?} clusters {} portals {} slivers {} same leafs {}", ours.clusters_from, ours.file.cells.count(), ours.file.cells.portals().len(), ours.slivers, ours.file.cluster_of_leaf == given.cluster_of_leaf);
        let mut by: HashMap<[u32; 2], Vec<&Portal>> = HashMap::new();
        for p in ours.file.cells.portals() { by.entry(key(p)).or_default().push(p); }
        let (mut matched, mut flipped, mut worst_out, mut worst_in, mut worst_d, mut lost, mut differ) = (0, 0, 0f64, 0f64, 0f64, 0, 0);
        for (n, g) in given.cells.portals().iter().enumerate() {
            let list = by.entry(key(g)).or_default();
            let best = list.iter().enumerate().max_by(|a, b| area(&common(&a.1.corners, &g.corners)).total_cmp(&area(&common(&b.1.corners, &g.corners)))).map(|x| x.0);
            let Some(best) = best else { lost += 1; eprintln!("   LOST {n} {:?} w {:.4} area {:.4} {:?}", g.cells, width(&g.corners), area(&g.corners), g.corners); continue };
            let o = list.swap_remove(best);
            let i = area(&common(&o.corners, &g.corners));
            let d = area(&o.corners) + area(&g.corners) - 2.0 * i;
            let s = sticks(&g.corners, &o.corners); let z = sticks(&o.corners, &g.corners);
            if s > 0.01 || z > 0.1 { differ += 1; if differ < 12 { eprintln!("   DIFF {n} {:?} given out {s:.4} ours out {z:.4} area {:.3} vs {:.3} d {d:.4}\n     {:?}\n     {:?}", g.cells, area(&g.corners), area(&o.corners), g.corners, o.corners); } } else { matched += 1; worst_out = worst_out.max(s); worst_in = worst_in.max(z); worst_d = worst_d.max(d); }
            if dot(newell(&g.corners), newell(&o.corners)) * (if g.cells == o.cells { 1.0 } else { -1.0 }) < 0.0 { flipped += 1; }
        }
        let mut extra: Vec<_> = by.values().flatten().collect();
        extra.sort_by(|a, b| width(&b.corners).total_cmp(&width(&a.corners)));
        eprintln!("   matched {matched} lost {lost} differ {differ} flipped {flipped} extra {} | given out of ours {worst_out:.6} ours out of given {worst_in:.6} area {worst_d:.5}", extra.len());
        for e in extra.iter().take(6) { eprintln!("   EXTRA {:?} width {:.5} area {:.4} {:?}", e.cells, width(&e.corners), area(&e.corners), e.corners); }
        let hist = |lo: f64, hi: f64| extra.iter().filter(|e| (lo..hi).contains(&width(&e.corners))).count();
        eprintln!("   extra widths >1 {} 0.2-1 {} 0.1-.2 {} .01-.1 {} .001-.01 {} <.001 {}", hist(1.0, 1e9), hist(0.2, 1.0), hist(0.1, 0.2), hist(0.01, 0.1), hist(0.001, 0.01), hist(0.0, 0.001));
    }
}
