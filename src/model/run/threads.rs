//! Number of threads: one per core by default, with an upper limit.

/// Most threads that can be asked for. More would fill the machine's memory and process table before any row is run.
pub const MOST_THREADS: usize = 1024;
/// Variables that set the number of threads, in the order in which rayon reads them.
const VARIABLES: [&str; 2] = ["RAYON_NUM_THREADS", "RAYON_RS_NUM_CPUS"];

/// A number of threads that cannot be started.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{name} is `{found}`, expected a whole number from 0 (one thread per core) to {MOST_THREADS}; {advice}")]
pub struct ThreadCountError {
    /// Name of the setting or the environment variable.
    name: &'static str,
    /// Value that was found.
    found: String,
    /// Remedy.
    advice: &'static str,
}

/// Returns the number of threads to start. `asked` 0: the value of `RAYON_NUM_THREADS`, or one thread per core.
///
/// # Errors
/// More than [`MOST_THREADS`]; an environment variable that holds no number.
pub fn thread_count(asked: usize) -> Result<usize, ThreadCountError> {
    if asked > MOST_THREADS {
        return Err(ThreadCountError { name: "threads", found: asked.to_string(), advice: "ask for fewer" });
    }
    if asked > 0 {
        return Ok(asked);
    }
    let set = VARIABLES.iter().find_map(|name| Some((*name, std::env::var_os(name)?)));
    let wanted = set.map(|(name, value)| by_variable(name, &value.to_string_lossy())).transpose()?;
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    Ok(wanted.filter(|count| *count > 0).unwrap_or_else(|| cores().min(MOST_THREADS)))
}

/// Reads the value of an environment variable.
fn by_variable(name: &'static str, value: &str) -> Result<usize, ThreadCountError> {
    let count = value.trim().parse().ok().filter(|count| *count <= MOST_THREADS);
    count.ok_or_else(|| ThreadCountError {
        name,
        found: value.chars().take(40).collect(),
        advice: "change or unset this environment variable",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_beyond_the_limit_are_refused_with_words() {
        assert_eq!((thread_count(3), thread_count(MOST_THREADS)), (Ok(3), Ok(1024)));
        let error = thread_count(1025).expect_err("too many").to_string();
        assert!(error.starts_with("threads is `1025`, expected a whole number from 0"), "{error}");
        assert_eq!((by_variable("RAYON_NUM_THREADS", "0"), by_variable("RAYON_NUM_THREADS", " 8 ")), (Ok(0), Ok(8)));
        for value in ["100000", "two", "", "-1"] {
            let error = by_variable("RAYON_NUM_THREADS", value).expect_err(value).to_string();
            assert!(error.contains(&format!("RAYON_NUM_THREADS is `{value}`")) && error.contains("unset"), "{error}");
        }
    }
}
