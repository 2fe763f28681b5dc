//! Columns of numbers, compressed by [`pco`].
//!
//! What a column could be told from other columns is not stored again: a prediction is subtracted first, on
//! the scale of the floating-point numbers themselves, so that nothing is rounded.

use super::error::Fault;
use pco::{
    ChunkConfig, DeltaSpec,
    data_types::Number,
    standalone::{simple_compress, simple_decompress_into},
};

/// Compressed columns, one after the other, each behind its length.
#[derive(Debug, Default)]
pub(super) struct Packer {
    bytes: Vec<u8>,
}

impl Packer {
    /// Adds a column whose neighbours may resemble each other.
    pub fn put<T: Number>(&mut self, numbers: &[T]) -> Result<(), Fault> {
        self.add(numbers, &ChunkConfig::default())
    }

    /// Adds a column of remainders, in which no order is left.
    pub fn put_remainders<T: Number>(&mut self, numbers: &[T]) -> Result<(), Fault> {
        let config = ChunkConfig::default().with_delta_spec(DeltaSpec::NoOp);
        self.add(numbers, &config)
    }

    /// Adds numbers that are whole multiples of one over `steps`, but for a few, each with what it is
    /// expected to be.
    pub fn put_stepped(
        &mut self,
        steps: f64,
        numbers: impl Iterator<Item = (f64, f64)>,
    ) -> Result<(), Fault> {
        let (mut whole, mut left) = (Vec::new(), Vec::new());
        for (x, expected) in numbers {
            let now = on_grid(x, steps);
            whole.push(now.wrapping_sub(on_grid(expected, steps)));
            left.push(surprise(x, from_grid(now, steps)));
        }
        self.put(&whole)?;
        self.put_remainders(&left)
    }

    fn add<T: Number>(&mut self, numbers: &[T], config: &ChunkConfig) -> Result<(), Fault> {
        let packed = simple_compress(numbers, config).map_err(|error| error.to_string())?;
        let length = u32::try_from(packed.len()).map_err(|_| "a column of 4 GB".to_string())?;
        self.bytes.extend(length.to_le_bytes());
        self.bytes.extend(packed);
        Ok(())
    }

    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }
}

/// Takes columns out again, in the same order.
#[derive(Debug)]
pub(super) struct Unpacker<'a> {
    bytes: &'a [u8],
}

impl<'a> Unpacker<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }

    /// The next column, which must have this many numbers.
    pub fn take<T: Number + Default>(&mut self, count: usize) -> Result<Vec<T>, Fault> {
        let short = || "a column is missing".to_string();
        let (length, rest) = self.bytes.split_first_chunk().ok_or_else(short)?;
        let length = u32::from_le_bytes(*length) as usize;
        let (packed, rest) = rest.split_at_checked(length).ok_or_else(short)?;
        self.bytes = rest;
        let mut numbers = vec![T::default(); count];
        let progress =
            simple_decompress_into(packed, &mut numbers).map_err(|error| error.to_string())?;
        if progress.n_processed != count || !progress.finished {
            return Err(format!("a column has not {count} numbers"));
        }
        Ok(numbers)
    }

    /// What [`Packer::put_stepped`] stored, as many as are expected.
    pub fn take_stepped(
        &mut self,
        steps: f64,
        expected: impl ExactSizeIterator<Item = f64>,
    ) -> Result<Vec<f64>, Fault> {
        let whole = self.take::<i32>(expected.len())?;
        let left = self.take::<i64>(expected.len())?;
        let numbers = expected
            .zip(whole)
            .zip(left)
            .map(|((expected, whole), left)| {
                let now = on_grid(expected, steps).wrapping_add(whole);
                surprised(left, from_grid(now, steps))
            });
        Ok(numbers.collect())
    }

    /// Verifies that nothing is left.
    pub fn finish(self) -> Result<(), Fault> {
        if self.bytes.is_empty() {
            Ok(())
        } else {
            Err("there are more columns than this program knows".into())
        }
    }
}

/// The nearest whole multiple of one over `steps`.
fn on_grid(x: f64, steps: f64) -> i32 {
    (x * steps).round_ties_even() as i32
}

fn from_grid(x: i32, steps: f64) -> f64 {
    f64::from(x) / steps
}

/// Place of a number among all floating-point numbers in their order; its neighbours differ by one.
fn rank(x: f64) -> i64 {
    let bits = x.to_bits().cast_signed();
    bits ^ ((bits >> 63).cast_unsigned() >> 1).cast_signed()
}

fn rank_f32(x: f32) -> i32 {
    let bits = x.to_bits().cast_signed();
    bits ^ ((bits >> 31).cast_unsigned() >> 1).cast_signed()
}

/// How many numbers lie between `x` and what was expected.
pub(super) fn surprise(x: f64, expected: f64) -> i64 {
    rank(x).wrapping_sub(rank(expected))
}

/// The number that differs so much from what was expected.
pub(super) fn surprised(surprise: i64, expected: f64) -> f64 {
    let rank = rank(expected).wrapping_add(surprise);
    f64::from_bits((rank ^ ((rank >> 63).cast_unsigned() >> 1).cast_signed()).cast_unsigned())
}

/// [`surprise`] of single precision.
pub(super) fn surprise_f32(x: f32, expected: f32) -> i32 {
    rank_f32(x).wrapping_sub(rank_f32(expected))
}

/// [`surprised`] of single precision.
pub(super) fn surprised_f32(surprise: i32, expected: f32) -> f32 {
    let rank = rank_f32(expected).wrapping_add(surprise);
    f32::from_bits((rank ^ ((rank >> 31).cast_unsigned() >> 1).cast_signed()).cast_unsigned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn surprises_keep_every_bit(x in any::<u64>(), y in any::<u64>()) {
            let (x, y) = (f64::from_bits(x), f64::from_bits(y));
            prop_assert_eq!(surprised(surprise(x, y), y).to_bits(), x.to_bits());
            let (x, y) = (x as f32, y as f32);
            prop_assert_eq!(surprised_f32(surprise_f32(x, y), y).to_bits(), x.to_bits());
        }
    }

    #[test]
    fn neighbours_differ_by_one_across_zero() {
        assert_eq!(surprise(-0.0, 0.0), -1);
        assert_eq!(surprise(f64::from_bits(1), 0.0), 1);
        assert_eq!(surprise(1.0_f64.next_up(), 1.0), 1);
        assert_eq!(surprise((-1.0_f64).next_up(), -1.0), 1);
        assert_eq!(surprise_f32(-0.0, 0.0), -1);
    }

    #[test]
    fn stepped_numbers_come_back_on_the_grid_and_off_it() {
        let numbers = [0.25, -0.5, 1e300, 0.1, -0.0, f64::INFINITY, 7.0];
        let expected = [0.25, 0.0, -1e300, 0.3, 1.0, f64::NAN, 6.5];
        let mut packer = Packer::default();
        packer
            .put_stepped(4.0, numbers.into_iter().zip(expected))
            .unwrap();
        let bytes = packer.finish();
        let back = Unpacker::new(&bytes)
            .take_stepped(4.0, expected.into_iter())
            .unwrap();
        assert_eq!(back.map_bits(), numbers.to_vec().map_bits());
    }

    #[test]
    fn columns_come_back_and_their_number_is_verified() {
        let mut packer = Packer::default();
        let floats = [1.0, -0.0, f64::NAN, f64::INFINITY];
        packer.put(&floats).unwrap();
        packer.put_remainders(&[3_i32, -4, 5]).unwrap();
        packer.put::<u16>(&[]).unwrap();
        let bytes = packer.finish();
        let mut unpacker = Unpacker::new(&bytes);
        let back = unpacker.take::<f64>(4).unwrap();
        assert_eq!(back.map_bits(), floats.to_vec().map_bits());
        assert_eq!(unpacker.take::<i32>(3).unwrap(), [3, -4, 5]);
        assert!(unpacker.take::<u16>(0).unwrap().is_empty());
        unpacker.finish().unwrap();

        for wrong in [3, 5, 1000] {
            assert!(Unpacker::new(&bytes).take::<f64>(wrong).is_err(), "{wrong}");
        }
        assert!(Unpacker::new(&bytes).take::<i64>(4).is_err());
        assert!(Unpacker::new(&bytes[..9]).take::<f64>(4).is_err());
        assert!(Unpacker::new(&bytes).finish().is_err());
    }

    trait Bits {
        fn map_bits(self) -> Vec<u64>;
    }

    impl Bits for Vec<f64> {
        fn map_bits(self) -> Vec<u64> {
            self.into_iter().map(f64::to_bits).collect()
        }
    }
}
