use std::io;

/// Why a file could not be read: which file, where in it, what is wrong and what to do.
#[derive(Debug, thiserror::Error)]
#[error("{file}, {place}: {problem}")]
pub struct AssetError {
    /// The file, as the user named it.
    pub file: String,
    /// The place in it: a JSON path, a line, a byte, a file that it refers to.
    pub place: String,
    /// What is wrong, with the remedy.
    #[source]
    pub problem: Problem,
}

/// What can be wrong with a file. Every text ends with the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// The operating system refuses.
    #[error("it can't be read ({0}). Check that the file exists, is a plain file and may be read.")]
    Io(#[from] io::Error),
    /// More was promised than is there.
    #[error(
        "{needed} bytes are needed but {there} are there. The file is cut off or its counts are wrong: export or download it again."
    )]
    Truncated {
        /// Bytes that the counts ask for.
        needed: u64,
        /// Bytes that are there.
        there: u64,
    },
    /// More than the budget allows.
    #[error("{found} {what} are more than the limit of {limit}. Simplify the file or split it.")]
    OverBudget {
        /// What was counted.
        what: &'static str,
        /// How many the file has.
        found: u64,
        /// How many are allowed.
        limit: u64,
    },
    /// A number that points to something that isn't there.
    #[error(
        "{what} {index} does not exist, there are {count}. The file contradicts itself: export it again."
    )]
    OutOfRange {
        /// What is pointed to.
        what: &'static str,
        /// The number.
        index: u64,
        /// How many there are.
        count: u64,
    },
    /// It isn't what the format says.
    #[error("{0}. The file is damaged or not what its name says: export it again.")]
    Malformed(String),
    /// A reference that leaves the file's folder.
    #[error(
        "\"{0}\" points outside the file's own folder, which is never followed. Put that file beside this one and refer to it by name, or export as one GLB."
    )]
    OutsideFolder(String),
    /// A valid file that uses what isn't supported.
    #[error("it uses {feature}, which is not supported. {remedy}")]
    Unsupported {
        /// What it uses.
        feature: String,
        /// What to do.
        remedy: &'static str,
    },
    /// Nothing to show.
    #[error("it holds no triangles. {0}")]
    Empty(&'static str),
}

/// A problem and its place, before the file is known by name.
#[derive(Debug)]
pub(super) struct Fault {
    pub place: String,
    pub problem: Problem,
}

impl Fault {
    pub fn new(place: impl Into<String>, problem: impl Into<Problem>) -> Self {
        Self { place: place.into(), problem: problem.into() }
    }

    pub fn malformed(place: impl Into<String>, what: impl Into<String>) -> Self {
        Self::new(place, Problem::Malformed(what.into()))
    }

    pub fn out_of_range(place: impl Into<String>, what: &'static str, index: usize, count: usize) -> Self {
        Self::new(place, Problem::OutOfRange { what, index: index as u64, count: count as u64 })
    }

    pub fn in_file(self, file: &str) -> AssetError {
        AssetError { file: file.to_string(), place: self.place, problem: self.problem }
    }
}
