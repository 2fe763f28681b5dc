use bevy_tectonics::prelude::*;
use std::ops::ControlFlow;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let get = |i: usize, d: f64| a.get(i).and_then(|s| s.parse().ok()).unwrap_or(d);
    let (seed, n, t, check) = (get(1, 1.0) as u64, get(2, 10000.0) as u32, get(3, 100.0), get(4, 0.0) > 0.0);
    let mut h = History::with_threads(Recipe::earth_like(seed).with_sub_plates(n).with_duration(t), get(6, 1.0) as usize).unwrap();
    let start = std::time::Instant::now();
    println!("{:?}", h.check());
    let mut next = 0.0;
    let mut k = 0.0;
    while h.time_my() < t {
        k += get(5, 25.0);
        if check {
            while h.time_my() < k.min(t) {
                h.step().unwrap_or_else(|e| panic!("{e} step {}", h.steps()));
                if let Err(e) = h.check() { println!("CHECK {e} step {}", h.steps()); next += 1.0; if next > 5.0 { return; } }
            }
        } else {
            h.run_until(k.min(t), |_| ControlFlow::Continue(())).unwrap();
        }
        let s = h.statistics().unwrap();
        let l = h.ledger();
        println!("{:5.0} st {:5} n {} land {:.3} cont {:.3} hc {:.1} hi {:.0} lo {:.0} mland {:.0} mocean {:.0} age {:.0}/{:.0} pl {} top {:.2} v {:.1}/{:.1} bl {:.0}k {:.2?} conc {:.2} mk {:.2} eat {:.2} sea {:.0} V {:.3} {:?}",
            h.time_my(), h.steps(), h.world().resource::<bevy_tectonics::simulation::Topology>().0.vertex_count(), s.land_share, s.continental_share, s.continental_thickness_km, s.highest_m, s.lowest_m, s.mean_land_m, s.mean_ocean_m,
            s.ocean_age_mean_my, s.ocean_age_oldest_my, s.plates, s.largest_plate, s.speed_mean, s.speed_median, s.boundary_km/1e3, s.boundary_shares, s.continental_concentration,
            l.area_created_km2/h.time_my()/1e6, l.area_consumed_km2/h.time_my()/1e6, s.sea_level_m, l.booked_km3()/l.initial_km3, start.elapsed());
    }
    println!("hash {:016x}", h.state_hash().unwrap());
    for (s, t) in h.stage_seconds() { println!("{s:20} {:.3}", t); }
}
