//! Mutates the corpus without a fuzzer's instruments: any machine, any compiler, the same inputs every time.
//!
//! ```text
//! cargo run -p bevy_tectonics_fuzz -- --inputs 10000
//! ```
//!
//! Exit code 0: no panic, no input that took longer than ten seconds, less than a gigabyte of memory.
//! 1: the input lies in `fuzz/artifacts/`, and `mutate --target NAME --file FILE` repeats it.

use bevy_tectonics_fuzz::{TARGETS, Target};
use clap::Parser;
use rand::{RngExt, SeedableRng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;
use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    process::{ExitCode, exit},
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

/// Longest time that an input may take.
const LONGEST: Duration = Duration::from_secs(10);
/// Most memory that the process may take, in kB.
const MOST_MEMORY_KB: u64 = 1_000_000;
/// What texts trip over.
const WORDS: [&str; 16] = [
    "1e999",
    "-1e-999",
    "-0",
    "NaN",
    "inf",
    "null",
    "[[[[[[[[",
    "{\"a\":",
    "18446744073709551616",
    "\u{0}",
    "\u{fffd}",
    "(",
    ")",
    "\"",
    "//",
    "/*",
];

#[derive(Parser)]
struct Arguments {
    /// Inputs of the quickest targets; slower ones have fewer
    #[arg(long, default_value_t = 1000)]
    inputs: u64,
    /// Where to begin: other numbers are other inputs
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Only this target
    #[arg(long)]
    target: Option<String>,
    /// Only this input
    #[arg(long, requires = "target")]
    file: Option<PathBuf>,
    /// Threads
    #[arg(long, default_value_t = thread::available_parallelism().map_or(1, |n| n.get()))]
    threads: usize,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let chosen = |target: &&Target| {
        let name = arguments.target.as_deref();
        name.is_none_or(|name| name == target.name)
    };
    let targets: Vec<&Target> = TARGETS.iter().filter(chosen).collect();
    if targets.is_empty() {
        let names: Vec<&str> = TARGETS.iter().map(|target| target.name).collect();
        eprintln!("error: the targets are {}", names.join(", "));
        return ExitCode::from(2);
    }
    if let (Some(file), [target]) = (&arguments.file, targets.as_slice()) {
        match fs::read(file) {
            Ok(input) => (target.run)(&input),
            Err(error) => {
                eprintln!("error: {}: {error}", file.display());
                return ExitCode::from(2);
            }
        }
        return ExitCode::SUCCESS;
    }
    println!("| target | inputs | seconds | slowest, s | failed |\n|---|--:|--:|--:|--:|");
    let failed: u64 = targets
        .iter()
        .map(|target| exercise(target, &arguments))
        .sum();
    let memory = peak_memory_kb();
    println!("\n{} MB of memory at most", memory / 1000);
    ExitCode::from(u8::from(failed > 0 || memory > MOST_MEMORY_KB))
}

/// Runs all inputs of a target and returns how many failed.
fn exercise(target: &Target, arguments: &Arguments) -> u64 {
    let corpus = corpus(target.name);
    let count = (arguments.inputs * target.weight).div_ceil(1000) + corpus.len() as u64;
    let (next, failed) = (AtomicU64::new(0), AtomicU64::new(0));
    let slowest = Mutex::new(Duration::ZERO);
    let under_way: Vec<Mutex<Option<(Instant, Vec<u8>)>>> = (0..arguments.threads.max(1))
        .map(|_| Mutex::new(None))
        .collect();
    let done = AtomicBool::new(false);
    let begun = Instant::now();
    let lock = |slot: &Mutex<Option<(Instant, Vec<u8>)>>, value| {
        *slot.lock().unwrap_or_else(PoisonError::into_inner) = value;
    };
    thread::scope(|scope| {
        let watch = scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                thread::park_timeout(Duration::from_millis(250));
                for slot in &under_way {
                    let slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
                    if let Some((since, input)) = &*slot
                        && since.elapsed() > LONGEST
                    {
                        eprintln!("{} took longer than {LONGEST:?}", keep(target, input));
                        exit(1);
                    }
                }
            }
        });
        let workers: Vec<_> = under_way
            .iter()
            .map(|slot| {
                scope.spawn(|| {
                    loop {
                        let number = next.fetch_add(1, Ordering::Relaxed);
                        if number >= count {
                            break;
                        }
                        let input = input(&corpus, arguments.seed, number);
                        let since = Instant::now();
                        lock(slot, Some((since, input.clone())));
                        let ran = catch_unwind(AssertUnwindSafe(|| (target.run)(&input)));
                        lock(slot, None);
                        let mut slowest = slowest.lock().unwrap_or_else(PoisonError::into_inner);
                        *slowest = since.elapsed().max(*slowest);
                        if ran.is_err() {
                            failed.fetch_add(1, Ordering::Relaxed);
                            eprintln!("{} failed", keep(target, &input));
                        }
                    }
                })
            })
            .collect();
        for worker in workers {
            let _ = worker.join();
        }
        done.store(true, Ordering::Relaxed);
        watch.thread().unpark();
    });
    let failed = failed.into_inner();
    println!(
        "| {} | {count} | {:.1} | {:.3} | {failed} |",
        target.name,
        begun.elapsed().as_secs_f64(),
        slowest
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner)
            .as_secs_f64(),
    );
    failed
}

/// All files of a target's corpus, in the order of their names.
fn corpus(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(target);
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    paths
        .iter()
        .filter_map(|path| fs::read(path).ok())
        .collect()
}

/// The corpus itself first, then its mutations.
fn input(corpus: &[Vec<u8>], seed: u64, number: u64) -> Vec<u8> {
    if let Some(input) = corpus.get(number as usize) {
        return input.clone();
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    let Some(mut input) = corpus.choose(&mut rng).cloned() else {
        // Choices of a random recipe.
        return (0..1200).map(|_| rng.random()).collect();
    };
    for _ in 0..rng.random_range(1..6) {
        mutate(&mut input, corpus, &mut rng);
    }
    input
}

fn mutate(input: &mut Vec<u8>, corpus: &[Vec<u8>], rng: &mut ChaCha8Rng) {
    if input.is_empty() {
        input.push(rng.random());
    }
    let length = input.len();
    let at = rng.random_range(0..length);
    let end = (at + rng.random_range(1..64)).min(length);
    match rng.random_range(0..12) {
        0 | 1 => input[at] = rng.random(),
        2 | 3 => input[at] ^= 1 << rng.random_range(0..8),
        4 => input[at] = b'0' + rng.random_range(0..10_u8),
        5 => input.insert(at, rng.random()),
        6 => drop(input.drain(at..end)),
        7 => input.truncate(at),
        8 => {
            let piece = input[at..end].repeat(rng.random_range(1..9));
            input.splice(at..at, piece);
        }
        9 => {
            let word = WORDS[rng.random_range(0..WORDS.len())];
            input.splice(at..end, word.bytes());
        }
        10 => {
            let extreme = [0, 0xff, 0x7f, 0x80][rng.random_range(0..4)];
            input[at..end.min(at + 8)].fill(extreme);
        }
        _ => {
            if let Some(other) = corpus.choose(rng).filter(|other| !other.is_empty()) {
                let from = rng.random_range(0..other.len());
                let to = (from + rng.random_range(1..256)).min(other.len());
                input.splice(at..end, other[from..to].iter().copied());
            }
        }
    }
}

/// Keeps an input that failed and returns where.
fn keep(target: &Target, input: &[u8]) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("artifacts")
        .join(target.name);
    let name = format!("{:016x}", xxhash_rust::xxh3::xxh3_64(input));
    let path = folder.join(name);
    let _ = fs::create_dir_all(&folder).and_then(|()| fs::write(&path, input));
    path.display().to_string()
}

/// Most memory the process has had, in kB; 0 where the system does not tell.
fn peak_memory_kb() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    let figure = line.and_then(|line| line.split_whitespace().nth(1));
    figure.and_then(|figure| figure.parse().ok()).unwrap_or(0)
}
