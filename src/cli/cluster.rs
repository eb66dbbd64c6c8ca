//! `decore slurm` and `decore hyperqueue`: a sweep's shards as tasks of a cluster's scheduler, then their merge.
//!
//! Both write a folder `<output>.cluster` with the script of one shard, that of the merge, and what the scheduler takes. The
//! scripts are the same for every sweep: paths and values stand in files beside them, one argument a line, and are never text
//! of a program.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;

use super::exit::{Exit, Failure, write_file};
use super::inputs::default_folder;
use super::outputs::{Form, Output, StudyArguments};
use super::shard::Shard;
use super::text::shell_word;
use super::written::Written;

/// Runs one shard, again if it was killed.
const TASK_SCRIPT: &str = include_str!("../assets/sweeps/task.sh");
/// Merges the shards.
const MERGE_SCRIPT: &str = include_str!("../assets/sweeps/merge.sh");
/// Submits the shards and the merge to HyperQueue.
const HYPERQUEUE_SCRIPT: &str = include_str!("../assets/sweeps/sweep_on_hyperqueue.py");

#[derive(Debug, Args)]
pub(super) struct ClusterArguments {
    /// Study file (TOML), in a folder that all nodes can read
    study: PathBuf,
    /// Number of shards; each is a task
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    tasks: u64,
    /// Folder for the combined tables (default: out/STUDY)
    ///
    /// Shards, scripts and logs are written next to it.
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Threads (cores) of each task
    #[arg(short, long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    threads: u64,
    /// Set a value of the study, for example `hammer.left.supply_bar=4.5`; repeatable
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Stop a task when more than this number of its rows have failed
    #[arg(long, value_name = "ROWS")]
    max_failed: Option<u64>,
    /// Retry diverged rows this many times
    #[arg(long, value_name = "TIMES")]
    retries: Option<u32>,
    /// Built-in test scene, as for `run`.
    #[arg(long, value_name = "MS", hide = true)]
    stub_row_ms: Option<f64>,
    /// Print the list of written files as JSON (schemas/written.schema.json)
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
pub(super) struct SlurmArguments {
    #[command(flatten)]
    cluster: ClusterArguments,
    /// Option for `sbatch`, for example `--sbatch=--time=08:00:00`; repeatable
    #[arg(long = "sbatch", value_name = "OPTION", allow_hyphen_values = true)]
    options: Vec<String>,
    /// Submit both jobs instead of printing the commands
    #[arg(long)]
    submit: bool,
}

#[derive(Debug, Args)]
pub(super) struct HyperQueueArguments {
    #[command(flatten)]
    cluster: ClusterArguments,
}

/// Folders and written files of a sweep on a cluster; all paths are absolute.
struct SweepScripts {
    output: PathBuf,
    folder: PathBuf,
    /// Files written so far.
    written: Written,
}

pub(super) fn slurm(arguments: &SlurmArguments) -> Result<Exit, Failure> {
    for option in &arguments.options {
        plain("--sbatch", OsStr::new(option))?;
    }
    let mut plan = SweepScripts::new(&arguments.cluster)?;
    let (task_log, merge_log) = (plan.log_option("task-%a.log")?, plan.log_option("merge.log")?);
    plan.write(&arguments.cluster)?;
    let stem = arguments.cluster.study.file_stem().unwrap_or_default().to_string_lossy();
    let safe = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    let name: String = stem.chars().map(safe).collect();
    let header = |kind: &str| {
        format!(
            "#!/bin/sh\n# Submit it in its folder.\n#SBATCH --job-name={kind}-{name}\n#SBATCH --open-mode=append\n\
             #SBATCH --requeue\n"
        )
    };
    let mut array = header("decore");
    let ClusterArguments { tasks, threads, .. } = arguments.cluster;
    array += &format!("#SBATCH --array=1-{tasks}\n#SBATCH --cpus-per-task={threads}\n");
    // A minute before its time is over a task is told to finish its rows and to queue again.
    array += "#SBATCH --signal=B:TERM@60\n";
    arguments.options.iter().for_each(|option| array += &format!("#SBATCH {option}\n"));
    array += "exec /bin/sh ./task.sh \"$SLURM_ARRAY_TASK_ID\"\n";
    let merge = header("decore-merge") + "exec /bin/sh ./merge.sh\n";
    plan.write_file("job", "array.sbatch", array)?;
    plan.write_file("job", "merge.sbatch", merge)?;
    let json = arguments.cluster.json;
    if arguments.submit {
        submit(plan, [&task_log, &merge_log], json)
    } else {
        advise(plan, [&task_log, &merge_log], json)
    }
}

/// Says how to submit both jobs, whose logs' options these are.
fn advise(mut plan: SweepScripts, [task_log, merge_log]: [&str; 2], json: bool) -> Result<Exit, Failure> {
    let commands = [
        format!("cd {}", shell_word(&plan.folder)),
        format!("id=$(sbatch --parsable {} array.sbatch)", shell_word(Path::new(task_log))),
        format!("sbatch --dependency=afterok:$id {} merge.sbatch", shell_word(Path::new(merge_log))),
    ];
    let words = format!("submit with:\n  {}", commands.join("\n  "));
    commands.into_iter().for_each(|command| plan.written.next(command));
    plan.written.print(json, &words)?;
    Ok(Exit::Done)
}

/// Submits both jobs, the merge to begin when all shards are done.
fn submit(mut plan: SweepScripts, [task_log, merge_log]: [&str; 2], json: bool) -> Result<Exit, Failure> {
    let id = plan.sbatch(&[task_log, "array.sbatch"])?;
    let merge_id = plan.sbatch(&[&format!("--dependency=afterok:{id}"), merge_log, "merge.sbatch"])?;
    let watch = format!("decore status {}/shard-*", shell_word(&plan.shards()));
    let tables = format!("tables go to {}", plan.output.display());
    let words = format!("array {id}, merge {merge_id}; {tables}\nwatch with: {watch}");
    [id, merge_id].into_iter().for_each(|number| plan.written.job(number));
    plan.written.note(tables);
    plan.written.next(watch);
    plan.written.print(json, &words)?;
    Ok(Exit::Done)
}

pub(super) fn hyperqueue(arguments: &HyperQueueArguments) -> Result<Exit, Failure> {
    let mut plan = SweepScripts::new(&arguments.cluster)?;
    plan.write(&arguments.cluster)?;
    let ClusterArguments { tasks, threads, .. } = arguments.cluster;
    let sizes = format!("{:#}\n", serde_json::json!({ "tasks": tasks, "threads": threads }));
    plan.write_file("settings", "sweep.json", sizes)?;
    plan.write_file("script", "sweep_on_hyperqueue.py", HYPERQUEUE_SCRIPT)?;
    let command = format!("python3 {}", shell_word(&plan.folder.join("sweep_on_hyperqueue.py")));
    let words = format!("run with:\n  {command} [--local]");
    plan.written.next(command);
    plan.written.print(arguments.cluster.json, &words)?;
    Ok(Exit::Done)
}

impl SweepScripts {
    fn new(arguments: &ClusterArguments) -> Result<Self, Failure> {
        let output = arguments.output.clone().unwrap_or_else(|| default_folder(&arguments.study));
        let output = absolute("--output", &output)?;
        let mut folder = output.clone().into_os_string();
        folder.push(".cluster");
        Ok(Self { folder: folder.into(), output, written: Written::default() })
    }

    /// Checks the study, then writes the files that every scheduler uses.
    fn write(&mut self, arguments: &ClusterArguments) -> Result<(), Failure> {
        let program = std::env::current_exe();
        let program = program.map_err(|source| Failure::Argument(format!("failed to find this program: {source}")))?;
        plain("this program", program.as_os_str())?;
        let run = run_command(&program, arguments)?;
        let outputs = [
            Output { flag: "--output", path: Some(&self.output), form: Form::Dataset },
            Output { flag: "--output", path: Some(&self.folder), form: Form::Folder { names: &[], replace: true } },
        ];
        let study = StudyArguments { file: &arguments.study, overrides: &arguments.overrides, outputs: &outputs };
        match arguments.stub_row_ms {
            Some(_) => drop(study.study()?),
            None => drop(study.engine()?),
        }
        for folder in [self.folder.clone(), self.folder.join("logs"), self.shards()] {
            let failed = |source| Failure::Write { path: folder.display().to_string(), source };
            fs::create_dir_all(&folder).map_err(failed)?;
        }
        let output = self.output.clone();
        let merge = [program.as_os_str(), "merge".as_ref(), "--output".as_ref(), output.as_os_str()];
        let tasks = arguments.tasks;
        let shards = (1..=tasks).map(|index| Shard { index, count: tasks }.folder(&self.output).into_os_string());
        let shards: Vec<OsString> = shards.collect();
        self.write_file("command", "run.arguments", lines(run.iter().map(OsString::as_os_str)))?;
        self.write_file("command", "merge.arguments", lines(merge.into_iter()))?;
        self.write_file("shards", "shards.list", lines(shards.iter().map(OsString::as_os_str)))?;
        self.write_file("script", "task.sh", TASK_SCRIPT)?;
        self.write_file("script", "merge.sh", MERGE_SCRIPT)
    }

    /// `sbatch`'s option for a log: patterns (`%a`) in its name alone are expanded, none in the folder's.
    fn log_option(&self, name: &str) -> Result<String, Failure> {
        let folder = self.folder.to_str().filter(|folder| !folder.contains('\\'));
        let folder = folder.ok_or_else(|| {
            let message = "expected a path in UTF-8 without backslashes, which Slurm drops from the names of logs";
            Failure::Argument(format!("--output: {:?}: {message}", self.output))
        })?;
        Ok(format!("--output={}/logs/{name}", folder.replace('%', "%%")))
    }

    fn write_file(&mut self, kind: &'static str, name: &str, content: impl AsRef<[u8]>) -> Result<(), Failure> {
        let path = self.folder.join(name);
        write_file(&path, content)?;
        self.written.file(kind, &path)
    }

    fn shards(&self) -> PathBuf {
        let mut shards = self.output.clone().into_os_string();
        shards.push(".shards");
        shards.into()
    }

    /// Runs `sbatch --parsable` in the folder, which becomes that of the job; returns the job's number.
    fn sbatch(&self, arguments: &[&str]) -> Result<String, Failure> {
        let output = Command::new("sbatch").arg("--parsable").args(arguments).current_dir(&self.folder).output();
        let output = output
            .map_err(|error| Failure::Argument(format!("failed to run sbatch: {error} (is Slurm installed?)")))?;
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
        if !output.status.success() {
            return Err(Failure::Argument(format!("sbatch refused the job: {}", text(&output.stderr))));
        }
        // `id` or `id;cluster`.
        Ok(text(&output.stdout).split(';').next().unwrap_or_default().to_owned())
    }
}

/// Command of a task without its shard.
fn run_command(program: &Path, arguments: &ClusterArguments) -> Result<Vec<OsString>, Failure> {
    let study = absolute("study", &arguments.study)?;
    let mut command = vec![program.into(), "run".into(), study.into_os_string()];
    let mut option = |name: &str, value: Option<String>| {
        command.extend(value.into_iter().flat_map(|value| [format!("--{name}").into(), value.into()]));
    };
    option("threads", Some(arguments.threads.to_string()));
    option("max-failed", arguments.max_failed.map(|most| most.to_string()));
    option("retries", arguments.retries.map(|times| times.to_string()));
    option("stub-row-ms", arguments.stub_row_ms.map(|time| time.to_string()));
    for one in &arguments.overrides {
        plain("--set", OsStr::new(one))?;
        option("set", Some(one.clone()));
    }
    Ok(command)
}

/// A path that a scheduler's files can carry.
fn absolute(what: &str, path: &Path) -> Result<PathBuf, Failure> {
    let failed = |source| Failure::Argument(format!("failed to make {} absolute: {source}", path.display()));
    let path = std::path::absolute(path).map_err(failed)?;
    plain(what, path.as_os_str())?;
    Ok(path)
}

/// Refuses control characters: an argument is a line of a file.
fn plain(what: &str, argument: &OsStr) -> Result<(), Failure> {
    let text = argument.to_string_lossy();
    match text.chars().find(|c| c.is_control()) {
        None => Ok(()),
        Some(found) => Err(Failure::Argument(format!(
            "{what}: the control character {found:?} in {text:?}: expected a name without line breaks, tabs and the like, \
             which no scheduler's script can carry (rename it)"
        ))),
    }
}

/// One argument a line.
fn lines<'a>(arguments: impl Iterator<Item = &'a OsStr>) -> Vec<u8> {
    arguments.flat_map(|argument| [argument.as_encoded_bytes(), b"\n"]).flatten().copied().collect()
}
