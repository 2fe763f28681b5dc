//! The file: a magic word, a version, a table of sections with their checksums, the sections.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `TECTONIC` |
//! | 4 | version |
//! | 4 | number of sections |
//! | 8 | length of the whole file |
//! | 32 each | name of a section (16 bytes of ASCII, padded with zeros), its length, its XXH3 checksum |
//! | 8 | XXH3 checksum of all the bytes before |
//! | | the sections, in their order |
//!
//! All numbers are little-endian and unsigned.

use super::SaveError;
use xxhash_rust::xxh3::xxh3_64;

const MAGIC: [u8; 8] = *b"TECTONIC";
/// Version of what this program writes; it reads all up to it.
pub(super) const VERSION: u32 = 1;
/// Bytes before the table, and of one of its rows.
const HEAD: usize = 24;
const ROW: usize = 32;
const NAME: usize = 16;

/// A section that was found whole.
#[derive(Debug, Clone, Copy)]
pub(super) struct Section<'a> {
    pub name: &'a str,
    /// Where it begins in the file.
    pub offset: u64,
    pub bytes: &'a [u8],
}

impl Section<'_> {
    /// A fault in this section.
    pub fn damaged(&self, what: impl ToString) -> SaveError {
        SaveError::Damaged {
            section: self.name.into(),
            offset: self.offset,
            what: what.to_string(),
        }
    }
}

/// Puts sections together. Names are ASCII and have at most 16 characters.
pub(super) fn assemble(sections: &[(String, Vec<u8>)]) -> Vec<u8> {
    let head = HEAD + ROW * sections.len() + 8;
    let length = head + sections.iter().map(|(_, bytes)| bytes.len()).sum::<usize>();
    let mut file = Vec::with_capacity(length);
    file.extend(MAGIC);
    file.extend(VERSION.to_le_bytes());
    file.extend((sections.len() as u32).to_le_bytes());
    file.extend((length as u64).to_le_bytes());
    for (name, bytes) in sections {
        let mut padded = [0; NAME];
        padded[..name.len()].copy_from_slice(name.as_bytes());
        file.extend(padded);
        file.extend((bytes.len() as u64).to_le_bytes());
        file.extend(xxh3_64(bytes).to_le_bytes());
    }
    let checksum = xxh3_64(&file);
    file.extend(checksum.to_le_bytes());
    for (_, bytes) in sections {
        file.extend(bytes);
    }
    file
}

/// Takes a file apart and verifies every checksum.
pub(super) fn open(file: &[u8]) -> Result<Vec<Section<'_>>, SaveError> {
    let truncated = |expected: usize| SaveError::Truncated {
        found: file.len() as u64,
        expected: expected as u64,
    };
    let magic = &file[..file.len().min(MAGIC.len())];
    if magic.is_empty() || !MAGIC.starts_with(magic) {
        let found = magic.to_vec();
        return Err(SaveError::Foreign { found });
    }
    let word = |at: usize| {
        let bytes = file.get(at..at + 4)?.try_into().ok()?;
        Some(u32::from_le_bytes(bytes))
    };
    let long = |at: usize| {
        let bytes = file.get(at..at + 8)?.try_into().ok()?;
        Some(u64::from_le_bytes(bytes))
    };
    let version = word(8).ok_or_else(|| truncated(HEAD))?;
    if version == 0 || version > VERSION {
        return Err(SaveError::Version {
            found: version,
            newest: VERSION,
        });
    }
    let (Some(count), Some(length)) = (word(12), long(16)) else {
        return Err(truncated(HEAD));
    };
    let header = |what: &str| SaveError::Damaged {
        section: "header".into(),
        offset: 0,
        what: what.into(),
    };
    let table = HEAD as u64 + ROW as u64 * u64::from(count);
    if length < table + 8 {
        return Err(header("its length and its number of sections do not fit"));
    }
    if length > file.len() as u64 {
        return Err(SaveError::Truncated {
            found: file.len() as u64,
            expected: length,
        });
    }
    if length < file.len() as u64 {
        return Err(header("bytes follow after the end"));
    }
    // No longer than the file, as is now known.
    let table = table as usize;
    if long(table) != Some(xxh3_64(&file[..table])) {
        return Err(header("the checksum does not fit"));
    }
    let mut sections = Vec::new();
    let mut at = table + 8;
    for row in file[HEAD..table].chunks_exact(ROW) {
        let name = row[..NAME].split(|&byte| byte == 0).next().unwrap_or(&[]);
        let name = str::from_utf8(name).map_err(|_| header("a section has no name"))?;
        let number = |at: usize| {
            let mut bytes = [0; 8];
            bytes.copy_from_slice(&row[at..at + 8]);
            u64::from_le_bytes(bytes)
        };
        let end = usize::try_from(number(NAME))
            .ok()
            .and_then(|length| at.checked_add(length));
        let bytes = end.and_then(|end| file.get(at..end));
        let bytes = bytes.ok_or_else(|| header("a section is longer than the file"))?;
        let section = Section {
            name,
            offset: at as u64,
            bytes,
        };
        if xxh3_64(bytes) != number(NAME + 8) {
            return Err(section.damaged("the checksum does not fit"));
        }
        sections.push(section);
        at += bytes.len();
    }
    if at != file.len() {
        return Err(header("the sections do not fill the file"));
    }
    Ok(sections)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file() -> Vec<u8> {
        let first = ("first".into(), b"some bytes".to_vec());
        assemble(&[first, ("empty".into(), Vec::new())])
    }

    #[test]
    fn sections_come_back() {
        let file = file();
        let sections = open(&file).unwrap();
        assert_eq!(sections.len(), 2);
        assert_eq!(
            (sections[0].name, sections[0].bytes),
            ("first", &b"some bytes"[..])
        );
        assert_eq!((sections[1].name, sections[1].bytes), ("empty", &b""[..]));
        assert_eq!(sections[1].offset, file.len() as u64);
    }

    #[test]
    fn every_cut_and_every_flipped_bit_is_noticed() {
        let file = file();
        for length in 0..file.len() {
            let error = open(&file[..length]).unwrap_err();
            let cut = matches!(error, SaveError::Truncated { found, .. } if found == length as u64);
            assert!(cut || length == 0, "{length}: {error}");
        }
        for bit in 0..8 * file.len() {
            let mut bad = file.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(open(&bad).is_err(), "bit {bit}");
        }
        let longer = [&file[..], b"!"].concat();
        assert!(matches!(open(&longer), Err(SaveError::Damaged { .. })));
    }

    #[test]
    fn other_files_and_later_versions_are_named() {
        assert!(matches!(
            open(b"\x89PNG\r\n\x1a\n"),
            Err(SaveError::Foreign { .. })
        ));
        assert!(matches!(open(b""), Err(SaveError::Foreign { .. })));
        let mut later = file();
        later[8] = 9;
        let message = open(&later).unwrap_err().to_string();
        assert!(
            message.contains("version 9") && message.contains("1 to 1"),
            "{message}"
        );
    }
}
