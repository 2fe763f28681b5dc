//! Which tiles are drawn, and which are missing: a walk down the tree of tiles.

use super::address::{Address, Bounds};
use glam::DVec3;

/// Length of a side, as a multiple of which a tile keeps away from every eye: nearer ones are split. Above
/// [`LEAST_REACH`], or neighbours could differ by more than a level.
pub(super) const LEAST_REACH: f64 = 2.6;

/// What decides on tiles. Lengths are in radii of the planet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Eyes<'a> {
    /// Where the cameras are, in the space of the planet's `Transform`.
    pub places: &'a [DVec3],
    /// Where they look.
    pub gazes: &'a [DVec3],
    /// Distance within which a tile is split, in sides of it.
    pub reach: f64,
    /// Tiles of this level are not split.
    pub deepest: u8,
    /// Radius of the sphere that hides what lies behind the horizon.
    pub horizon: f64,
}

/// The tiles to draw and those to make.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Choice {
    /// They cover what the eyes may see, each place once.
    pub drawn: Vec<Address>,
    /// Most urgent first.
    pub wanted: Vec<Wanted>,
}

/// A tile that is missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wanted {
    pub address: Address,
    pub urgency: f64,
    /// Whether an eye looks that way.
    pub in_view: bool,
}

/// How much less urgent what lies behind an eye is.
const BEHIND: f64 = 0.2;

impl Eyes<'_> {
    /// `bounds` are those of a tile's ground, if the tile is there.
    pub fn choose(&self, bounds: impl Fn(Address) -> Option<Bounds>) -> Choice {
        let mut choice = Choice::default();
        for root in Address::roots() {
            match bounds(root) {
                Some(found) => self.visit(root, found, &bounds, &mut choice),
                None => choice.wanted.push(Wanted {
                    address: root,
                    urgency: f64::INFINITY,
                    in_view: true,
                }),
            }
        }
        choice.wanted.sort_by(|a, b| {
            b.urgency
                .total_cmp(&a.urgency)
                .then(a.address.cmp(&b.address))
        });
        choice
    }

    fn visit(
        &self,
        address: Address,
        bounds: Bounds,
        bounds_of: &impl Fn(Address) -> Option<Bounds>,
        choice: &mut Choice,
    ) {
        let rises = |eye: &DVec3| bounds.rises(*eye, self.horizon);
        if !self.places.iter().any(rises) {
            return;
        }
        let nearest = self.places.iter().map(|&eye| bounds.distance(eye));
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        let reach = self.reach * address.size();
        if address.level >= self.deepest || nearest >= reach {
            choice.drawn.push(address);
            return;
        }
        let children = address.children();
        let found = children.map(bounds_of);
        if let [Some(a), Some(b), Some(c), Some(d)] = found {
            for (child, bounds) in children.into_iter().zip([a, b, c, d]) {
                self.visit(child, bounds, bounds_of, choice);
            }
            return;
        }
        choice.drawn.push(address);
        let in_view = self.is_in_view(address, &bounds);
        let urgency = reach / nearest.max(1e-3 * reach) * if in_view { 1.0 } else { BEHIND };
        let missing = children.into_iter().zip(found);
        let missing = missing.filter(|(_, bounds)| bounds.is_none());
        choice.wanted.extend(missing.map(|(address, _)| Wanted {
            address,
            urgency,
            in_view,
        }));
    }

    /// Whether some part of a tile lies within some 60 degrees of where an eye looks, or very close to it.
    fn is_in_view(&self, address: Address, bounds: &Bounds) -> bool {
        self.places.iter().zip(self.gazes).any(|(&eye, &gaze)| {
            let way = address.middle() - eye;
            let ahead = way.dot(gaze) + 0.75 * address.size();
            ahead > 0.5 * way.length() || bounds.distance(eye) < address.size()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn eyes(places: &[DVec3]) -> Eyes<'_> {
        Eyes {
            places,
            gazes: &[DVec3::NEG_X],
            reach: LEAST_REACH,
            deepest: 12,
            horizon: 1.0,
        }
    }

    /// Ground up to 4,000 m above a sea like Earth's.
    #[expect(clippy::unnecessary_wraps, reason = "as the choice asks for it")]
    fn bounds(address: Address) -> Option<Bounds> {
        Some(Bounds::new(address, 1.0, 1.0 + 4000.0 / 6.371e6))
    }

    #[test]
    fn drawn_tiles_cover_what_is_seen_once() {
        let place = [DVec3::new(1.001, 0.01, -0.02)];
        let choice = eyes(&place).choose(bounds);
        assert!(choice.wanted.is_empty());
        assert!(choice.drawn.len() > 100);
        for a in &choice.drawn {
            let mut above = a.parent();
            while let Some(address) = above {
                assert!(!choice.drawn.contains(&address), "{a:?} twice");
                above = address.parent();
            }
        }
        // Straight below is the finest.
        let finest = choice.drawn.iter().map(|tile| tile.level).max();
        let size = Address {
            level: finest.unwrap(),
            face: 0,
            x: 0,
            y: 0,
        }
        .size();
        assert!(size < 0.0012 && size > 0.0002, "{size}");
    }

    #[test]
    fn neighbours_differ_by_a_level_at_most() {
        for place in [
            DVec3::new(1.0006, 0.0, 0.0),
            DVec3::new(0.7, 0.72, -0.01),
            DVec3::new(0.9, -0.6, 0.55),
        ] {
            let choice = eyes(&[place]).choose(bounds);
            let drawn: std::collections::HashSet<_> = choice.drawn.iter().copied().collect();
            for tile in &choice.drawn {
                for (dx, dy) in [(1, 0), (0, 1)] {
                    let (x, y) = (tile.x + dx, tile.y + dy);
                    if x >> tile.level > 0 || y >> tile.level > 0 {
                        continue;
                    }
                    // The one beside, or what stands for it.
                    let mut beside = Some(Address { x, y, ..*tile });
                    while let Some(address) = beside.filter(|address| !drawn.contains(address)) {
                        beside = address.parent();
                    }
                    if let Some(beside) = beside {
                        assert!(tile.level - beside.level <= 1, "{tile:?} beside {beside:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_missing_is_wanted_nearest_first_and_stood_in_for() {
        let place = [DVec3::new(1.01, 0.0, 0.0)];
        let none = eyes(&place).choose(|_| None);
        assert_eq!((none.drawn.len(), none.wanted.len()), (0, 6));
        let some = eyes(&place).choose(|address| bounds(address).filter(|_| address.level < 3));
        assert!(some.drawn.iter().all(|tile| tile.level < 3));
        assert!(some.wanted.iter().all(|wanted| wanted.address.level == 3));
        let urgency: Vec<f64> = some.wanted.iter().map(|wanted| wanted.urgency).collect();
        assert!(urgency.is_sorted_by(|a, b| a >= b));
        let nearest = some.wanted[0].address;
        assert_eq!(nearest.face, 0);
    }
}
