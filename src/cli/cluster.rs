//! `decore slurm` and `decore hyperqueue`: a sweep's shards as tasks of a cluster's scheduler, then their merge.
//!
//! Both write a folder `<output>.cluster` with the script of one shard, that of the merge, and what the scheduler takes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;

use super::exit::{Exit, Failure};
use super::run::default_folder;
use super::shard::Shard;
use super::text::say;
use crate::engine::Engine;
use crate::study::Study;

/// Runs one shard, again if it was killed.
const TASK_SCRIPT: &str = include_str!("task.sh");
/// Submits the shards and the merge to HyperQueue.
const HYPERQUEUE_SCRIPT: &str = include_str!("sweep_on_hyperqueue.py");

#[derive(Debug, Args)]
pub(super) struct ClusterArguments {
    /// Study file (TOML), in a folder that all machines see.
    study: PathBuf,
    /// Number of shards, each a task.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    tasks: u64,
    /// Folder for the merged tables; shards, scripts and logs go beside it. Default: `out/` and the study's name.
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Threads (cores) of each task.
    #[arg(short, long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    threads: u64,
    /// Set a value of the study, e.g. `hammer.left.supply_bar=4.5`; may be given several times.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Stop a task when more of its rows than this are not done.
    #[arg(long, value_name = "ROWS")]
    max_failed: Option<u64>,
    /// Times a row that diverged is run again.
    #[arg(long, value_name = "TIMES")]
    retries: Option<u32>,
    /// Built-in test scene, as for `run`.
    #[arg(long, value_name = "MS", hide = true)]
    stub_row_ms: Option<f64>,
}

#[derive(Debug, Args)]
pub(super) struct SlurmArguments {
    #[command(flatten)]
    cluster: ClusterArguments,
    /// A further option of the array's tasks, as `sbatch` takes it, e.g. `--sbatch=--time=08:00:00`; may be given several
    /// times.
    #[arg(long = "sbatch", value_name = "OPTION", allow_hyphen_values = true)]
    options: Vec<String>,
    /// Submit both jobs; otherwise the commands are printed.
    #[arg(long)]
    submit: bool,
}

#[derive(Debug, Args)]
pub(super) struct HyperQueueArguments {
    #[command(flatten)]
    cluster: ClusterArguments,
}

/// Where a sweep's scripts are and what it consists of; all paths absolute.
struct Plan {
    study: PathBuf,
    output: PathBuf,
    folder: PathBuf,
    program: PathBuf,
    tasks: u64,
    threads: u64,
}

pub(super) fn slurm(arguments: &SlurmArguments) -> Result<Exit, Failure> {
    let plan = write_scripts(&arguments.cluster)?;
    let name =
        arguments.cluster.study.file_stem().unwrap_or_default().to_string_lossy().replace(char::is_whitespace, "-");
    let logs = plan.logs();
    let header = |kind: &str, log: &str| {
        format!(
            "#!/bin/sh\n#SBATCH --job-name={kind}-{name}\n#SBATCH --open-mode=append\n#SBATCH --requeue\n\
             #SBATCH --output={}\n",
            quoted_for_sbatch(&logs.join(log))
        )
    };
    let mut array = header("decore", "task-%a.log");
    array += &format!("#SBATCH --array=1-{}\n#SBATCH --cpus-per-task={}\n", plan.tasks, plan.threads);
    // A minute before its time is over a task is told to finish its rows and to queue again.
    array += "#SBATCH --signal=B:TERM@60\n";
    arguments.options.iter().for_each(|option| array += &format!("#SBATCH {option}\n"));
    array += &format!("exec /bin/sh {} \"$SLURM_ARRAY_TASK_ID\"\n", quoted(&plan.task_script()));
    let merge = header("decore-merge", "merge.log") + &format!("exec /bin/sh {}\n", quoted(&plan.merge_script()));
    let (array_path, merge_path) = (plan.folder.join("array.sbatch"), plan.folder.join("merge.sbatch"));
    write(&array_path, &array)?;
    write(&merge_path, &merge)?;
    if !arguments.submit {
        say(&format_args!(
            "submit with:\n  id=$(sbatch --parsable {})\n  sbatch --dependency=afterok:$id {}",
            quoted(&array_path),
            quoted(&merge_path)
        ));
        return Ok(Exit::Done);
    }
    let id = sbatch(&[array_path.as_os_str()])?;
    let dependency = format!("--dependency=afterok:{id}");
    let merge_id = sbatch(&[dependency.as_ref(), merge_path.as_os_str()])?;
    say(&format_args!("array {id}, merge {merge_id}; tables go to {}", plan.output.display()));
    say(&format_args!("watch with: decore status {}/shard-*", plan.shards().display()));
    Ok(Exit::Done)
}

pub(super) fn hyperqueue(arguments: &HyperQueueArguments) -> Result<Exit, Failure> {
    let plan = write_scripts(&arguments.cluster)?;
    let path = plan.folder.join("sweep_on_hyperqueue.py");
    // JSON strings are Python strings.
    let text = |path: &Path| serde_json::Value::from(path.to_string_lossy()).to_string();
    let script = HYPERQUEUE_SCRIPT
        .replace("@STUDY@", &format!("written for {}", plan.study.display()))
        .replace("@TASKS@", &plan.tasks.to_string())
        .replace("@THREADS@", &plan.threads.to_string())
        .replace("@TASK@", &text(&plan.task_script()))
        .replace("@MERGE@", &text(&plan.merge_script()))
        .replace("@LOGS@", &text(&plan.logs()));
    write(&path, &script)?;
    say(&format_args!("run with:\n  python3 {} [--local]", quoted(&path)));
    Ok(Exit::Done)
}

/// Runs `sbatch --parsable`; returns the job's number.
fn sbatch(arguments: &[&std::ffi::OsStr]) -> Result<String, Failure> {
    let output = Command::new("sbatch").arg("--parsable").args(arguments).output();
    let output =
        output.map_err(|error| Failure::Argument(format!("failed to run sbatch: {error} (is Slurm installed?)")))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    if !output.status.success() {
        return Err(Failure::Argument(format!("sbatch refused the job: {}", text(&output.stderr))));
    }
    // `id` or `id;cluster`.
    Ok(text(&output.stdout).split(';').next().unwrap_or_default().to_owned())
}

/// Checks the study, then writes the scripts that every scheduler uses.
fn write_scripts(arguments: &ClusterArguments) -> Result<Plan, Failure> {
    match arguments.stub_row_ms {
        Some(_) => Study::load(&arguments.study)?.with_overrides(&arguments.overrides).map(|_| ())?,
        None => Engine::load(&arguments.study, &arguments.overrides).map(|_| ())?,
    }
    let plan = Plan::new(arguments)?;
    for folder in [plan.folder.clone(), plan.logs(), plan.shards()] {
        let failed = |source| Failure::Write { path: folder.display().to_string(), source };
        fs::create_dir_all(&folder).map_err(failed)?;
    }
    let task = TASK_SCRIPT
        .replace("@STUDY@", &format!("written for {}", plan.study.display()))
        .replace("@COMMAND@", &plan.run_command(arguments))
        .replace("@SHARDS@", &quoted(&plan.shards()))
        .replace("@TASKS@", &plan.tasks.to_string());
    write(&plan.task_script(), &task)?;
    let whole = &plan.output;
    let shards = (1..=plan.tasks).map(|index| quoted(&Shard { index, count: plan.tasks }.folder(whole)));
    let merge = format!(
        "#!/bin/sh\n{} merge --output {} {}\ncode=$?\n# 4: some rows are not done, which is a result.\n\
         [ \"$code\" -eq 4 ] && exit 0\nexit \"$code\"\n",
        quoted(&plan.program),
        quoted(whole),
        shards.collect::<Vec<_>>().join(" ")
    );
    write(&plan.merge_script(), &merge)?;
    Ok(plan)
}

impl Plan {
    fn new(arguments: &ClusterArguments) -> Result<Self, Failure> {
        let absolute = |path: &Path| {
            let failed = |source| Failure::Argument(format!("failed to make {} absolute: {source}", path.display()));
            std::path::absolute(path).map_err(failed)
        };
        let output = arguments.output.clone().unwrap_or_else(|| default_folder(&arguments.study));
        let output = absolute(&output)?;
        let mut folder = output.clone().into_os_string();
        folder.push(".cluster");
        let program = std::env::current_exe();
        Ok(Self {
            study: absolute(&arguments.study)?,
            output,
            folder: folder.into(),
            program: program.map_err(|source| Failure::Argument(format!("failed to find this program: {source}")))?,
            tasks: arguments.tasks,
            threads: arguments.threads,
        })
    }

    fn run_command(&self, arguments: &ClusterArguments) -> String {
        let mut command = format!("{} run {} --threads {}", quoted(&self.program), quoted(&self.study), self.threads);
        arguments.overrides.iter().for_each(|one| command += &format!(" --set {}", quoted(Path::new(one))));
        let mut option = |name: &str, value: Option<String>| {
            if let Some(value) = value {
                command += &format!(" --{name} {value}");
            }
        };
        option("max-failed", arguments.max_failed.map(|most| most.to_string()));
        option("retries", arguments.retries.map(|times| times.to_string()));
        option("stub-row-ms", arguments.stub_row_ms.map(|time| time.to_string()));
        command
    }

    fn logs(&self) -> PathBuf {
        self.folder.join("logs")
    }

    fn task_script(&self) -> PathBuf {
        self.folder.join("task.sh")
    }

    fn merge_script(&self) -> PathBuf {
        self.folder.join("merge.sh")
    }

    fn shards(&self) -> PathBuf {
        let mut shards = self.output.clone().into_os_string();
        shards.push(".shards");
        shards.into()
    }
}

/// For a shell: in single quotes.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.to_string_lossy().replace('\'', "'\\''"))
}

/// For a line `#SBATCH`: in double quotes.
fn quoted_for_sbatch(path: &Path) -> String {
    format!("\"{}\"", path.to_string_lossy())
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    fs::write(path, text).map_err(|source| Failure::Write { path: path.display().to_string(), source })
}
