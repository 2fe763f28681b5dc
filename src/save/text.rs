//! Text and bytes of any kind, deflated.

use super::error::Fault;
use flate2::{Compression, bufread::ZlibDecoder, write::ZlibEncoder};
use std::io::{Read, Write};

pub(super) fn deflate(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    // Memory takes every byte.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

/// At most `most` bytes; more is a fault, found before they are all in memory.
pub(super) fn inflate(bytes: &[u8], most: usize) -> Result<Vec<u8>, Fault> {
    let mut inflated = Vec::new();
    let mut decoder = ZlibDecoder::new(bytes).take(most as u64 + 1);
    decoder
        .read_to_end(&mut inflated)
        .map_err(|error| error.to_string())?;
    if inflated.len() > most {
        return Err(format!("it holds more than {most} bytes"));
    }
    Ok(inflated)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back_within_their_limit() {
        let text = b"words, words, words".repeat(1000);
        let small = deflate(&text);
        assert!(small.len() < text.len() / 20);
        assert_eq!(inflate(&small, text.len()).unwrap(), text);
        assert!(
            inflate(&small, text.len() - 1)
                .unwrap_err()
                .contains("18999")
        );
        assert!(inflate(&small[..small.len() / 2], 1 << 20).is_err());
    }
}
