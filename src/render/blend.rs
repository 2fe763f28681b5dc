//! From one snapshot to the next without a jump.

/// Seconds that a blend takes at least and at most.
const SECONDS: (f32, f32) = (0.15, 1.0);

/// Two of three sets of maps are seen, blending from one to the other; the third is written meanwhile.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Blend {
    pub from: usize,
    pub to: usize,
    pub spare: usize,
    /// How far the blend has come, 0 to 1.
    pub share: f32,
    /// Seconds it takes in all.
    seconds: f32,
    /// Seconds between snapshots, smoothed.
    interval: f32,
    /// Seconds since the last snapshot arrived.
    since: f32,
}

impl Default for Blend {
    fn default() -> Self {
        Self {
            from: 0,
            to: 1,
            spare: 2,
            share: 1.0,
            seconds: SECONDS.0,
            interval: SECONDS.0,
            since: 0.0,
        }
    }
}

impl Blend {
    pub(super) fn advance(&mut self, seconds: f32) {
        let seconds = seconds.max(0.0);
        self.since += seconds;
        self.share = (self.share + seconds / self.seconds).min(1.0);
    }

    pub(super) fn is_over(&self) -> bool {
        self.share >= 1.0
    }

    /// Notes that a snapshot has arrived.
    pub(super) fn arrived(&mut self) {
        let interval = self.since.clamp(SECONDS.0, SECONDS.1);
        self.interval += 0.5 * (interval - self.interval);
        self.since = 0.0;
    }

    /// Begins to blend towards the spare set; what was seen first becomes the spare one. The blend
    /// takes about as long as the next snapshot will, so that continents move without pause.
    pub(super) fn turn(&mut self) {
        (self.from, self.to, self.spare) = (self.to, self.spare, self.from);
        self.share = 0.0;
        self.seconds = (1.1 * self.interval).clamp(SECONDS.0, SECONDS.1);
    }

    /// Shows the target at once.
    pub(super) fn finish(&mut self) {
        self.share = 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_take_turns_and_what_is_seen_never_jumps() {
        let mut blend = Blend::default();
        for _ in 0..7 {
            let seen = blend.to;
            blend.turn();
            assert_eq!((blend.from, blend.share), (seen, 0.0));
            let mut sets = [blend.from, blend.to, blend.spare];
            sets.sort_unstable();
            assert_eq!(sets, [0, 1, 2]);
            blend.advance(f32::MAX);
            assert!(blend.is_over());
        }
    }

    #[test]
    fn a_blend_lasts_until_the_next_snapshot() {
        let mut blend = Blend::default();
        for _ in 0..20 {
            blend.advance(0.5);
            blend.arrived();
        }
        blend.turn();
        blend.advance(0.45);
        assert!(!blend.is_over());
        blend.advance(0.2);
        assert!(blend.is_over());
    }
}
