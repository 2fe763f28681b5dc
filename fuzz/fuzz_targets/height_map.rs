#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| bevy_tectonics_fuzz::height_map(data));
