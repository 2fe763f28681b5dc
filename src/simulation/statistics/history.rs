//! What a planet measured over time.

use super::Statistics;
use bevy::prelude::*;
use core::fmt;
use serde::{
    Deserialize, Deserializer, Serialize,
    de::{Error, SeqAccess, Visitor},
};

/// Concentration of continents beyond which they are gathered in one, and below which they have
/// broken up. Earth's present one is 0.27; one cap of 41 % of the sphere has 0.59.
const GATHERED: f64 = 0.5;
const SCATTERED: f64 = 0.2;

/// A planet's measures over time, the earliest first.
///
/// Moments hold the single figures; distributions are left empty, so that a long history stays small:
/// half a kilobyte a moment. In a simulation's world a resource that grows while a
/// [`StatisticsInterval`](super::StatisticsInterval) is set, and with
/// [`History::record_statistics`](crate::simulation::History::record_statistics).
#[derive(Resource, Debug, Clone, Default, PartialEq, Serialize, Deserialize, Reflect)]
#[reflect(Resource, Default)]
pub struct StatisticsHistory {
    #[serde(deserialize_with = "at_most")]
    moments: Vec<Statistics>,
}

/// Most moments that are read: one every 0.1 My of the longest history. A moment of defaults is three letters in a
/// file and half a kilobyte here.
const MOST_MOMENTS: usize = 100_000;

fn at_most<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Statistics>, D::Error> {
    struct Moments;

    impl<'de> Visitor<'de> for Moments {
        type Value = Vec<Statistics>;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            write!(f, "at most {MOST_MOMENTS} moments")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
            let mut moments = Vec::new();
            while let Some(moment) = list.next_element()? {
                if moments.len() == MOST_MOMENTS {
                    return Err(A::Error::invalid_length(moments.len() + 1, &self));
                }
                moments.push(moment);
            }
            Ok(moments)
        }
    }

    deserializer.deserialize_seq(Moments)
}

/// Something that continents did as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gathering {
    /// They had gathered at this time, in My: their concentration rose above 0.5.
    Gathered(f64),
    /// They had broken up at this time, in My: it fell below 0.2.
    BrokenUp(f64),
}

impl StatisticsHistory {
    /// The moments, the earliest first.
    #[must_use]
    pub fn moments(&self) -> &[Statistics] {
        &self.moments
    }

    /// Adds a moment. Whatever is not earlier gives way to it: a history that is measured again, or
    /// goes on from an earlier time.
    pub fn push(&mut self, moment: &Statistics) {
        self.moments.truncate(self.earlier(moment.time_my));
        self.moments.push(moment.compact());
    }

    /// The last moment before a time, in My.
    #[must_use]
    pub fn before(&self, time_my: f64) -> Option<&Statistics> {
        self.moments.get(self.earlier(time_my).checked_sub(1)?)
    }

    /// One figure over time as pairs of My and value.
    pub fn series(&self, figure: impl Fn(&Statistics) -> f64) -> impl Iterator<Item = (f64, f64)> {
        self.moments
            .iter()
            .map(move |moment| (moment.time_my, figure(moment)))
    }

    /// When the continents gathered in one and when they broke up again, in turn. What they were at
    /// the first moment is no event.
    #[must_use]
    pub fn gatherings(&self) -> Vec<Gathering> {
        let mut events = Vec::new();
        let mut gathered = None;
        for (i, moment) in self.moments.iter().enumerate() {
            let time_my = moment.time_my;
            let now = if moment.continental_concentration > GATHERED {
                Some(true)
            } else if moment.continental_concentration < SCATTERED {
                Some(false)
            } else {
                // In between they stay what they were.
                gathered
            };
            if i > 0 && now != gathered {
                events.extend(now.map(|gathered| {
                    if gathered {
                        Gathering::Gathered(time_my)
                    } else {
                        Gathering::BrokenUp(time_my)
                    }
                }));
            }
            gathered = now;
        }
        events
    }

    /// Whether another moment is due at a time, in My, if they shall lie on multiples of an interval.
    pub(super) fn is_due(&self, time_my: f64, interval_my: f64) -> bool {
        self.moments.last().is_none_or(|last| {
            (time_my / interval_my).floor() > (last.time_my / interval_my).floor()
        })
    }

    /// Number of moments before a time.
    fn earlier(&self, time_my: f64) -> usize {
        self.moments
            .partition_point(|moment| moment.time_my < time_my)
    }
}
