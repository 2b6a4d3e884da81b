//! Remembers costly results on disk between runs. Never the only copy of anything: a missing folder, a full
//! disk or a damaged entry only means that the result is computed again.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::SystemTime;

use super::hash::{ContentHasher, content_hash};

/// Fields of a few dozen rooms at 256³ fit; more is evicted, the longest unused first.
const MAX_TOTAL_BYTES: u64 = 1 << 30;

/// Names the layout of an entry; another value is read as no entry.
const MAGIC: [u8; 8] = *b"INHABIT1";

/// Magic and checksum.
const HEADER_BYTES: usize = 8 + 16;

/// The bytes last put under `key`, or `None` if there are none or they don't pass their checksum.
pub fn get(key: &str) -> Option<Vec<u8>> {
    Cache::of_user()?.get(key)
}

/// Keeps `bytes` under `key`. Says nothing when that fails.
pub fn put(key: &str, bytes: &[u8]) {
    if let Some(cache) = Cache::of_user() {
        cache.put(key, bytes);
    }
}

/// A folder of cached results.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
    max_total_bytes: u64,
}

impl Cache {
    /// The user's cache: `INHABIT_CACHE_DIR`, else `inhabit` in the platform's folder for caches.
    pub fn of_user() -> Option<Self> {
        Some(Self::at(user_folder(|name| std::env::var_os(name))?, MAX_TOTAL_BYTES))
    }

    /// A cache in `folder`, which is made when first needed, of at most `max_total_bytes`.
    pub fn at(folder: PathBuf, max_total_bytes: u64) -> Self {
        Self { folder, max_total_bytes }
    }

    /// See [`get`].
    pub fn get(&self, key: &str) -> Option<Vec<u8>> {
        let path = self.path(key);
        let mut entry = fs::read(&path).ok()?;
        let (header, bytes) = entry.split_at_checked(HEADER_BYTES)?;
        if header != header_of(key, bytes) {
            return None;
        }
        touch(&path);
        Some(entry.split_off(HEADER_BYTES))
    }

    /// See [`put`].
    pub fn put(&self, key: &str, bytes: &[u8]) {
        let size = (HEADER_BYTES + bytes.len()) as u64;
        if size > self.max_total_bytes || fs::create_dir_all(&self.folder).is_err() {
            return;
        }
        self.evict(self.max_total_bytes - size);
        let mut entry = header_of(key, bytes).to_vec();
        entry.extend_from_slice(bytes);
        let path = self.path(key);
        let unfinished = unfinished_name(&path);
        if fs::write(&unfinished, entry).and_then(|()| fs::rename(&unfinished, &path)).is_err() {
            let _ = fs::remove_file(&unfinished);
        }
    }

    fn path(&self, key: &str) -> PathBuf {
        self.folder.join(format!("{:032x}.bin", content_hash(key.as_bytes())))
    }

    /// Removes the longest unused entries until at most `max_bytes` are left.
    fn evict(&self, max_bytes: u64) {
        let mut entries = self.entries();
        entries.sort_unstable();
        let mut total: u64 = entries.iter().map(|(_, _, size)| size).sum();
        for (_, path, size) in entries {
            if total <= max_bytes {
                return;
            }
            if fs::remove_file(&path).is_ok() {
                total -= size;
            }
        }
    }

    /// When each of our files was last used, where it is, and its size. Foreign files aren't ours to count.
    fn entries(&self) -> Vec<(SystemTime, PathBuf, u64)> {
        let Ok(folder) = fs::read_dir(&self.folder) else { return Vec::new() };
        let ours = |path: &Path| path.extension().is_some_and(|e| e == "bin" || e == "unfinished");
        folder
            .flatten()
            .filter(|entry| ours(&entry.path()))
            .filter_map(|entry| {
                let about = entry.metadata().ok()?;
                Some((about.modified().ok()?, entry.path(), about.len()))
            })
            .collect()
    }
}

fn header_of(key: &str, bytes: &[u8]) -> [u8; HEADER_BYTES] {
    let mut hasher = ContentHasher::default();
    hasher.write(key.as_bytes());
    hasher.write(bytes);
    let mut header = [0; HEADER_BYTES];
    header[..8].copy_from_slice(&MAGIC);
    header[8..].copy_from_slice(&hasher.finish().to_le_bytes());
    header
}

/// A name beside `path` that no other writer uses at the same time.
fn unfinished_name(path: &Path) -> PathBuf {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let number = COUNTER.fetch_add(1, Ordering::Relaxed);
    path.with_extension(format!("{}-{number}.unfinished", std::process::id()))
}

/// Marks an entry as used now; an entry that can't be marked is only evicted earlier.
fn touch(path: &Path) {
    if let Ok(file) = fs::File::options().append(true).open(path) {
        let _ = file.set_modified(SystemTime::now());
    }
}

/// Where the user's caches lie, given a way to ask for environment variables.
fn user_folder(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    let folder = |name: &str| variable(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    if let Some(own) = folder("INHABIT_CACHE_DIR") {
        return Some(own);
    }
    let caches = if cfg!(windows) {
        folder("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        folder("HOME").map(|home| home.join("Library").join("Caches"))
    } else {
        folder("XDG_CACHE_HOME").or_else(|| folder("HOME").map(|home| home.join(".cache")))
    };
    caches.map(|caches| caches.join("inhabit"))
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn cache(max_total_bytes: u64) -> (tempfile::TempDir, Cache) {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::at(folder.path().join("made when needed"), max_total_bytes);
        (folder, cache)
    }

    #[test]
    fn what_was_put_comes_back_and_nothing_else() {
        let (_folder, cache) = cache(1000);
        assert_eq!(cache.get("a"), None);
        cache.put("a", b"one");
        cache.put("b", b"");
        cache.put("a", b"two");
        assert_eq!(cache.get("a").as_deref(), Some(&b"two"[..]));
        assert_eq!(cache.get("b").as_deref(), Some(&b""[..]));
        assert_eq!(cache.get("c"), None);
    }

    #[test]
    fn a_damaged_or_misplaced_entry_is_no_entry() {
        let (_folder, cache) = cache(1000);
        cache.put("a", b"some content");
        let whole = fs::read(cache.path("a")).unwrap();
        for length in 0..whole.len() {
            fs::write(cache.path("a"), &whole[..length]).unwrap();
            assert_eq!(cache.get("a"), None, "cut to {length} bytes");
        }
        for at in 0..whole.len() {
            let mut flipped = whole.clone();
            flipped[at] ^= 4;
            fs::write(cache.path("a"), flipped).unwrap();
            assert_eq!(cache.get("a"), None, "flipped at {at}");
        }
        fs::write(cache.path("b"), whole).unwrap();
        assert_eq!(cache.get("b"), None, "an entry of another key");
    }

    #[test]
    fn the_folder_stays_within_its_limit_and_the_longest_unused_goes_first() {
        let (_folder, cache) = cache(300);
        for (age_s, key) in [(30, "old"), (20, "middle"), (10, "new")] {
            cache.put(key, &[7; 60]);
            let file = fs::File::options().append(true).open(cache.path(key)).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(age_s)).unwrap();
        }
        assert!(cache.get("old").is_some());
        cache.put("more", &[7; 60]);
        assert!(cache.get("middle").is_none());
        assert!(["old", "new", "more"].iter().all(|key| cache.get(key).is_some()));
        cache.put("too big", &[7; 400]);
        assert!(cache.get("too big").is_none() && cache.get("more").is_some());
        assert!(cache.entries().iter().map(|e| e.2).sum::<u64>() <= 300);
    }

    #[test]
    fn a_folder_that_cannot_be_made_fails_silently() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("file"), b"").unwrap();
        let cache = Cache::at(folder.path().join("file"), 1000);
        cache.put("a", b"one");
        assert_eq!(cache.get("a"), None);
    }

    #[test]
    fn the_users_own_choice_of_folder_comes_first() {
        let both = |name: &str| match name {
            "INHABIT_CACHE_DIR" => Some(OsString::from("chosen")),
            _ => Some(OsString::from("base")),
        };
        assert_eq!(user_folder(both), Some(PathBuf::from("chosen")));
        let without = |name: &str| (name != "INHABIT_CACHE_DIR").then(|| OsString::from("base"));
        assert!(user_folder(without).unwrap().ends_with("inhabit"));
        assert_eq!(user_folder(|_| None), None);
    }
}
