//! Checksums find accidents. Whoever means harm makes them fit.

use xxhash_rust::xxh3::xxh3_64;

/// A save whose table and checksums fit what is in it, as far as it has a table.
pub fn save(data: &[u8]) -> Vec<u8> {
    const HEAD: usize = 24;
    const ROW: usize = 32;
    let mut file = data.to_vec();
    let Some(count) = data.get(12..16).and_then(|count| count.try_into().ok()) else {
        return file;
    };
    let length = file.len() as u64;
    file[16..24.min(length as usize)]
        .copy_from_slice(&length.to_le_bytes()[..8.min(length as usize - 16)]);
    let table = HEAD.saturating_add(ROW.saturating_mul(u32::from_le_bytes(count) as usize));
    if table.saturating_add(8) > file.len() {
        return file;
    }
    let mut at = table + 8;
    let rows = (table - HEAD) / ROW;
    for row in 0..rows {
        let begin = HEAD + ROW * row + 16;
        let mut bytes = [0; 8];
        bytes.copy_from_slice(&file[begin..begin + 8]);
        let rest = file.len() - at;
        // The last section takes what is left, so that cuts and insertions are found in it.
        let length = if row + 1 == rows {
            rest
        } else {
            (u64::from_le_bytes(bytes) as usize).min(rest)
        };
        let checksum = xxh3_64(&file[at..at + length]);
        file[begin..begin + 8].copy_from_slice(&(length as u64).to_le_bytes());
        file[begin + 8..begin + 16].copy_from_slice(&checksum.to_le_bytes());
        at += length;
    }
    let checksum = xxh3_64(&file[..table]);
    file[table..table + 8].copy_from_slice(&checksum.to_le_bytes());
    file
}

/// A PNG whose chunks have checksums that fit.
pub fn png(data: &[u8]) -> Vec<u8> {
    let mut file = data.to_vec();
    let mut at = 8;
    while let Some(head) = file.get(at..at + 8) {
        let mut length = [0; 4];
        length.copy_from_slice(&head[..4]);
        let end = at + 8 + u32::from_be_bytes(length) as usize;
        if end + 4 > file.len() {
            break;
        }
        let checksum = crc32fast::hash(&file[at + 4..end]);
        file[end..end + 4].copy_from_slice(&checksum.to_be_bytes());
        at = end + 4;
    }
    file
}
