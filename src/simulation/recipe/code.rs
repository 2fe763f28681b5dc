//! Recipes to send to a friend: as a code that can be dictated, or as text.
//!
//! A code is Crockford's base 32, in groups of five, of these bytes:
//!
//! | bytes | content |
//! |---|---|
//! | 1 | version in the upper four bits; in the lower four which of the following differ from their defaults |
//! | varint | seed |
//! | varint | number of sub-plates |
//! | varint | duration: hundredths of a My, doubled; or 1 and the eight bytes of any other number |
//! | rest | everything else as in the text, deflated |
//! | 3 | XXH3 checksum of all that |
//!
//! Varints are little-endian groups of seven bits, as in LEB128.

use super::{Recipe, Start, sparse};
use crate::simulation::TectonicError;
use core::{fmt, str::FromStr};
use data_encoding::{Encoding, Specification};
use flate2::{Compression, bufread::DeflateDecoder, write::DeflateEncoder};
use std::{
    io::{Read, Write},
    sync::LazyLock,
};
use thiserror::Error;
use xxhash_rust::xxh3::xxh3_64;

/// Version of the codes that are made.
const VERSION: u8 = 1;
const SEED: u8 = 1;
const SUB_PLATES: u8 = 2;
const DURATION: u8 = 4;
const REST: u8 = 8;
/// Bytes of the checksum: one wrong code in 16 million passes.
const CHECKSUM: usize = 3;
/// Characters in a group.
const GROUP: usize = 5;
/// What may stand between the characters of a code.
const IGNORED: &str = "- \t\r\n";
/// Longest text of a recipe in bytes: 10,000 events of 100 places each.
const LONGEST: usize = 32 << 20;

/// Why a text is no recipe.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RecipeError {
    /// A character that no code has.
    #[error("{found:?}, character {place} of the code, is not in any code")]
    Character {
        /// Which character, from 1 on.
        place: usize,
        /// The character.
        found: char,
    },
    /// Not all characters are there, or one is wrong.
    #[error("the code does not add up: a character is wrong, missing or too many")]
    Checksum,
    /// A code of a later version.
    #[error("the code is of version {found}, and this program reads versions 1 to {newest}")]
    Version {
        /// Version of the code.
        found: u8,
        /// Newest version that can be read.
        newest: u8,
    },
    /// A text that cannot be read.
    #[error("line {line}, column {column} of the recipe: {what}")]
    Text {
        /// Line, from 1 on.
        line: usize,
        /// Column, from 1 on.
        column: usize,
        /// What is wrong there.
        what: String,
    },
    /// Too long a text.
    #[error("the recipe is longer than {most} bytes")]
    TooLong {
        /// Largest length in bytes.
        most: usize,
    },
    /// A code that names files.
    #[error("the code begins with files of another machine, {files:?}")]
    Files {
        /// Path of the height map.
        files: String,
    },
    /// A value outside its range.
    #[error(transparent)]
    Value(#[from] TectonicError),
}

/// Digits and letters that nobody confuses; read as they may be written.
static BASE_32: LazyLock<Encoding> = LazyLock::new(|| {
    let mut specification = Specification::new();
    specification
        .symbols
        .push_str("0123456789ABCDEFGHJKMNPQRSTVWXYZ");
    specification
        .translate
        .from
        .push_str("abcdefghjkmnpqrstvwxyzILOilo");
    specification
        .translate
        .to
        .push_str("ABCDEFGHJKMNPQRSTVWXYZ110110");
    specification.ignore.push_str(IGNORED);
    #[expect(
        clippy::expect_used,
        reason = "a constant, which every test of a code reads"
    )]
    specification.encoding().expect("the alphabet is sound")
});

/// A short code that grows the same planet: `{}`. A text to read and to edit, in RON: `{:#}`. Both leave out
/// what is as in [`Recipe::default`], and both are read by [`str::parse`].
///
/// ```
/// use bevy_tectonics::prelude::*;
///
/// let recipe = Recipe::earth_like(7).with_sub_plates(40_000);
/// assert_eq!(recipe.to_string(), "2C3W1-E024M-7F6");
/// assert_eq!("2c3w1 eo24m 7f6".parse(), Ok(recipe.clone()));
/// assert_eq!(format!("{recipe:#}").parse(), Ok(recipe));
/// ```
///
/// A code grows the same planet with the same version of this crate. Later versions read it, but may grow
/// another planet from it. That of a recipe which starts from files is refused: send the text and the files.
impl fmt::Display for Recipe {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = if f.alternate() {
            sparse::text(self, true).map_err(|_| fmt::Error)?
        } else {
            encode(self).map_err(|_| fmt::Error)?
        };
        f.write_str(&text)
    }
}

impl FromStr for Recipe {
    type Err = RecipeError;

    /// Reads a code or a text, and validates the recipe.
    fn from_str(text: &str) -> Result<Self, RecipeError> {
        if text.len() > LONGEST {
            return Err(RecipeError::TooLong { most: LONGEST });
        }
        // No code has parentheses.
        let recipe = if text.contains('(') {
            read(text)?
        } else {
            decode(text)?
        };
        recipe.validate()?;
        Ok(recipe)
    }
}

fn read(text: &str) -> Result<Recipe, RecipeError> {
    let options =
        ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
    options.from_str(text).map_err(|error| RecipeError::Text {
        line: error.span.start.line,
        column: error.span.start.col,
        what: error.code.to_string(),
    })
}

fn encode(recipe: &Recipe) -> Result<String, ron::Error> {
    let usual = Recipe::default();
    let mut bytes = vec![VERSION << 4];
    if recipe.seed != usual.seed {
        bytes[0] |= SEED;
        put_varint(&mut bytes, recipe.seed);
    }
    if recipe.sub_plates != usual.sub_plates {
        bytes[0] |= SUB_PLATES;
        put_varint(&mut bytes, recipe.sub_plates.into());
    }
    if recipe.duration_my != usual.duration_my {
        bytes[0] |= DURATION;
        let hundredths = 100.0 * recipe.duration_my;
        let whole = hundredths as u64;
        if whole as f64 == hundredths && whole as f64 / 100.0 == recipe.duration_my {
            put_varint(&mut bytes, whole << 1);
        } else {
            put_varint(&mut bytes, 1);
            bytes.extend(recipe.duration_my.to_le_bytes());
        }
    }
    let rest = Recipe {
        seed: usual.seed,
        sub_plates: usual.sub_plates,
        duration_my: usual.duration_my,
        ..recipe.clone()
    };
    if rest != usual {
        bytes[0] |= REST;
        let text = sparse::text(&rest, false)?;
        let mut encoder = DeflateEncoder::new(bytes, Compression::best());
        encoder.write_all(text.as_bytes())?;
        bytes = encoder.finish()?;
    }
    bytes.extend(checksum(&bytes));
    let letters = BASE_32.encode(&bytes);
    let groups = letters.as_bytes().chunks(GROUP);
    let groups: Vec<&str> = groups
        .filter_map(|group| str::from_utf8(group).ok())
        .collect();
    Ok(groups.join("-"))
}

fn decode(code: &str) -> Result<Recipe, RecipeError> {
    let is_known =
        |c: char| c.is_ascii_alphanumeric() && !matches!(c, 'U' | 'u') || IGNORED.contains(c);
    if let Some((place, found)) = (1..).zip(code.chars()).find(|(_, c)| !is_known(*c)) {
        return Err(RecipeError::Character { place, found });
    }
    let bytes = BASE_32
        .decode(code.as_bytes())
        .map_err(|_| RecipeError::Checksum)?;
    let (bytes, sum) = bytes
        .split_last_chunk::<CHECKSUM>()
        .ok_or(RecipeError::Checksum)?;
    if *sum != checksum(bytes) {
        return Err(RecipeError::Checksum);
    }
    let (&head, mut bytes) = bytes.split_first().ok_or(RecipeError::Checksum)?;
    if head >> 4 != VERSION {
        return Err(RecipeError::Version {
            found: head >> 4,
            newest: VERSION,
        });
    }
    let mut plain = Recipe::default();
    let mut number = || take_varint(&mut bytes).ok_or(RecipeError::Checksum);
    if head & SEED != 0 {
        plain.seed = number()?;
    }
    if head & SUB_PLATES != 0 {
        plain.sub_plates = u32::try_from(number()?).map_err(|_| RecipeError::Checksum)?;
    }
    if head & DURATION != 0 {
        let hundredths = number()?;
        if hundredths % 2 == 0 {
            plain.duration_my = (hundredths >> 1) as f64 / 100.0;
        } else {
            let (duration, rest) = bytes.split_first_chunk().ok_or(RecipeError::Checksum)?;
            plain.duration_my = f64::from_le_bytes(*duration);
            bytes = rest;
        }
    }
    if head & REST == 0 {
        return if bytes.is_empty() {
            Ok(plain)
        } else {
            Err(RecipeError::Checksum)
        };
    }
    let mut text = String::new();
    DeflateDecoder::new(bytes)
        .take(LONGEST as u64 + 1)
        .read_to_string(&mut text)
        .map_err(|_| RecipeError::Checksum)?;
    if text.len() > LONGEST {
        return Err(RecipeError::TooLong { most: LONGEST });
    }
    let rest = read(&text)?;
    // What a stranger sends shall not open a file.
    if let Start::Image(image) = &rest.start {
        return Err(RecipeError::Files {
            files: image.heights.clone(),
        });
    }
    Ok(Recipe {
        seed: plain.seed,
        sub_plates: plain.sub_plates,
        duration_my: plain.duration_my,
        ..rest
    })
}

fn checksum(bytes: &[u8]) -> [u8; CHECKSUM] {
    let sum = xxh3_64(bytes).to_le_bytes();
    core::array::from_fn(|i| sum[i])
}

fn put_varint(bytes: &mut Vec<u8>, mut number: u64) {
    while number >= 0x80 {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
}

fn take_varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut number = 0_u64;
    for shift in (0..64).step_by(7) {
        let (&byte, rest) = bytes.split_first()?;
        *bytes = rest;
        let part = u64::from(byte & 0x7f);
        number |= part
            .checked_shl(shift)
            .filter(|shifted| shifted >> shift == part)?;
        if byte & 0x80 == 0 {
            return Some(number);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::{Drive, Intervention, LatLon, Start};
    use proptest::prelude::*;

    fn odd() -> Recipe {
        let mut recipe = Recipe::earth_like(u64::MAX)
            .with_sub_plates(2_000_000)
            .with_duration(1_234.567_891)
            .with_event(
                12.5,
                Intervention::Rift {
                    line: vec![
                        LatLon { lat: 1.0, lon: 2.0 },
                        LatLon {
                            lat: -3.5,
                            lon: 40.25,
                        },
                    ],
                },
            );
        recipe.start = Start::Hypsometric(crate::simulation::Hypsometry::default());
        recipe.drive = Drive::Foundering;
        recipe.constants.motion.slab_pull *= 1.1;
        recipe.constants.erosion.rise_width = 0.0;
        recipe
    }

    #[test]
    fn plain_recipes_fit_in_forty_characters() {
        for seed in [0, 7, 123_456_789, u64::MAX] {
            let plain = Recipe::earth_like(seed)
                .with_sub_plates(2_000_000)
                .with_duration(9_999.99);
            let code = plain.to_string();
            assert!(code.len() <= 40, "{code}: {} characters", code.len());
            assert_eq!(code.parse(), Ok(plain));
        }
        assert_eq!(Recipe::default().to_string().parse(), Ok(Recipe::default()));
    }

    #[test]
    fn everything_in_a_recipe_survives_both_ways() {
        let recipe = odd();
        let code = recipe.to_string();
        assert!(code.len() < 500, "{}", code.len());
        assert_eq!(code.parse(), Ok(recipe.clone()));
        let text = format!("{recipe:#}");
        assert_eq!(text.parse(), Ok(recipe));
        // What is as usual is left out.
        assert!(
            text.lines().count() < 40 && !text.contains("land_share"),
            "{text}"
        );
    }

    #[test]
    fn a_code_opens_no_files() {
        let image = crate::simulation::ImageStart {
            heights: "/dev/zero".into(),
            ..Default::default()
        };
        let recipe = Recipe {
            start: Start::Image(image),
            ..Recipe::default()
        };
        let files = "/dev/zero".into();
        let code = recipe.to_string().parse::<Recipe>();
        assert_eq!(code, Err(RecipeError::Files { files }));
        assert_eq!(format!("{recipe:#}").parse(), Ok(recipe));
    }

    #[test]
    fn codes_are_read_as_people_write_them() {
        let recipe = Recipe::earth_like(1_000_003);
        let code = recipe.to_string();
        let typed = code
            .to_lowercase()
            .replace('-', " ")
            .replace('0', "o")
            .replace('1', "l");
        assert_eq!(typed.parse(), Ok(recipe));
    }

    #[test]
    fn wrong_codes_say_what_is_wrong() {
        let code = odd().to_string();
        let parse = |code: &str| code.parse::<Recipe>().unwrap_err();
        assert_eq!(
            parse("ABC!D"),
            RecipeError::Character {
                place: 4,
                found: '!'
            }
        );
        assert_eq!(
            parse("ABCÜD"),
            RecipeError::Character {
                place: 4,
                found: 'Ü'
            }
        );
        assert_eq!(parse(""), RecipeError::Checksum);
        // Every character swapped with its neighbour, left out, or another one.
        let letters: Vec<char> = code.chars().filter(|c| *c != '-').collect();
        for i in 0..letters.len() {
            let mut missing = letters.clone();
            missing.remove(i);
            let mut wrong = letters.clone();
            wrong[i] = if wrong[i] == '7' { '8' } else { '7' };
            let mut swapped = letters.clone();
            swapped.swap(i, (i + 1) % letters.len());
            for bad in [missing, wrong, swapped] {
                let code: String = bad.iter().collect();
                if bad != letters {
                    assert_eq!(parse(&code), RecipeError::Checksum, "{code}");
                }
            }
        }
        let mut later = vec![9 << 4];
        later.extend(checksum(&later));
        let error = RecipeError::Version {
            found: 9,
            newest: 1,
        };
        assert_eq!(parse(&BASE_32.encode(&later)), error);
    }

    #[test]
    fn wrong_texts_say_where() {
        let parse = |text: &str| text.parse::<Recipe>().unwrap_err();
        let error = parse("(\n  seed: 7,\n  sub_plate: 3,\n)");
        assert!(
            matches!(error, RecipeError::Text { line: 3, .. }),
            "{error}"
        );
        assert!(error.to_string().contains("sub_plate"), "{error}");
        assert!(matches!(
            parse("(seed: -1)"),
            RecipeError::Text { line: 1, .. }
        ));
        let message = parse("(plates: 1)").to_string();
        assert_eq!(message, "plates is 1, but must be between 2 and 200");
        assert!(matches!(
            parse("(events: [[[[[[[["),
            RecipeError::Text { .. }
        ));
        let deep = "(".repeat(100_000);
        assert!(matches!(parse(&deep), RecipeError::Text { .. }));
    }

    proptest! {
        #[test]
        fn any_plain_recipe_survives(seed: u64, sub_plates in 480_u32..2_000_000, duration in 0.0..10_000.0) {
            let recipe = Recipe::earth_like(seed).with_sub_plates(sub_plates).with_duration(duration);
            prop_assert_eq!(recipe.to_string().parse(), Ok(recipe.clone()));
            prop_assert_eq!(format!("{:#}", recipe).parse(), Ok(recipe));
        }

        #[test]
        fn no_text_panics(text in ".{0,60}") {
            let _ = text.parse::<Recipe>();
        }

        #[test]
        fn no_bytes_panic(bytes in proptest::collection::vec(any::<u8>(), 0..40)) {
            let mut bytes = bytes;
            bytes.extend(checksum(&bytes));
            let _ = BASE_32.encode(&bytes).parse::<Recipe>();
        }
    }
}
