use bevy_tectonics::prelude::*;
use std::ops::ControlFlow;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let get = |i: usize, d: f64| a.get(i).and_then(|s| s.parse().ok()).unwrap_or(d);
    let (seed, n, t, check) = (
        get(1, 1.0) as u64,
        get(2, 10000.0) as u32,
        get(3, 100.0),
        get(4, 0.0) > 0.0,
    );
    let mut h = History::with_threads(
        Recipe::earth_like(seed).with_sub_plates(n).with_duration(t),
        get(6, 1.0) as usize,
    )
    .unwrap();
    let start = std::time::Instant::now();
    println!("{:?}", h.check());
    let mut next = 0.0;
    let mut k = 0.0;
    while h.time_my() < t {
        k += get(5, 25.0);
        if check {
            while h.time_my() < k.min(t) {
                h.step()
                    .unwrap_or_else(|e| panic!("{e} step {}", h.steps()));
                if let Err(e) = h.check() {
                    println!("CHECK {e} step {}", h.steps());
                    next += 1.0;
                    if next > 5.0 {
                        return;
                    }
                }
            }
        } else {
            h.run_until(k.min(t), |_| ControlFlow::Continue(()))
                .unwrap();
        }
        let s = h.statistics().unwrap();
        let l = h.ledger();
        println!(
            "{:5.0} st {:5} n {} land {:.3} cont {:.3} hc {:.1} hi {:.0} lo {:.0} mland {:.0} mocean {:.0} age {:.0}/{:.0} pl {} top {:.2} v {:.1}/{:.1} bl {:.0}k {:.2?} conc {:.2} mk {:.2} eat {:.2} sea {:.0} V {:.3} {:?}",
            h.time_my(),
            h.steps(),
            h.world()
                .resource::<bevy_tectonics::simulation::Topology>()
                .0
                .vertex_count(),
            s.land_share,
            s.continental_share,
            s.continental_thickness_km,
            s.highest_m,
            s.lowest_m,
            s.mean_land_m,
            s.mean_ocean_m,
            s.ocean_age_mean_my,
            s.ocean_age_oldest_my,
            s.plates,
            s.largest_plate,
            s.speed_mean,
            s.speed_median,
            s.boundary_km / 1e3,
            s.boundary_shares,
            s.continental_concentration,
            l.area_created_km2 / h.time_my() / 1e6,
            l.area_consumed_km2 / h.time_my() / 1e6,
            s.sea_level_m,
            l.booked_km3() / l.initial_km3,
            start.elapsed()
        );
    }
    if get(7, 0.0) > 0.0 {
        let f = h.surface().unwrap();
        let n = f.mesh.vertex_count();
        let old: Vec<bool> = (0..n)
            .map(|v| f.crust[v] == Crust::Oceanic && f.age[v] > get(7, 0.0) as f32)
            .collect();
        let mut seen = vec![false; n];
        for s in 0..n {
            if !old[s] || seen[s] {
                continue;
            }
            let mut st = vec![s as u32];
            seen[s] = true;
            let (mut k, mut land, mut front, mut oldest, mut edges) = (0, 0, 0, 0f32, 0);
            let mut plates = std::collections::BTreeSet::new();
            while let Some(v) = st.pop() {
                k += 1;
                oldest = oldest.max(f.age[v as usize]);
                plates.insert(f.plate[v as usize]);
                let mut l = false;
                let mut fr = false;
                for w in f.mesh.neighbours(v) {
                    let w = w as usize;
                    edges += 1;
                    l |= f.crust[w] == Crust::Continental;
                    fr |= f.plate[w] != f.plate[v as usize];
                    if old[w] && !seen[w] {
                        seen[w] = true;
                        st.push(w as u32);
                    }
                }
                land += l as u32;
                front += fr as u32;
            }
            let _ = edges;
            let pl = *plates.iter().next().unwrap();
            let size = (0..n).filter(|&v| f.plate[v] == pl).count();
            let oce = (0..n)
                .filter(|&v| f.plate[v] == pl && f.crust[v] == Crust::Oceanic)
                .count();
            let dir = f.mesh.site(s as u32);
            println!(
                "old piece: cells {k} beside land {land} at front {front} oldest {oldest:.0} plates {plates:?} of {size} cells, {oce} oceanic, lat {:.0} lon {:.0}",
                dir.z.asin().to_degrees(),
                dir.y.atan2(dir.x).to_degrees()
            );
        }
    }
    println!("hash {:016x}", h.state_hash().unwrap());
    for (s, t) in h.stage_seconds() {
        println!("{s:20} {:.3}", t);
    }
}
