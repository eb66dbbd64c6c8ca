//! Sweeps on real schedulers, started here on one machine: Slurm (`DECORE_SLURM=1`; needs the Debian packages `slurm-wlm`
//! and `munge`, and root) and HyperQueue (`DECORE_HYPERQUEUE=<python>`; needs `pip install hyperqueue`).

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::sweeps::{STUDY, assert_same, decore, errors, expect_code, output, signal, sweep};
use tempfile::TempDir;

const TASKS: u64 = 4;
const ROWS: u64 = 2000;
/// Exit code of a sweep with rows that are not done.
const ROWS_FAILED: i32 = 4;
/// Longest time for all that a scheduler does.
const PATIENCE: Duration = Duration::from_secs(240);

/// A folder's name with what shells, Python, Slurm and HyperQueue give a meaning to.
const FORGED: &str = r#"it's """ %j %{TASK_ID} @TASKS@ $(touch forged) `touch forged` ÁÉ * ;& #"#;

/// A folder of this name with a copy of the study.
fn study_folder(scratch: &TempDir, name: &str) -> PathBuf {
    let folder = scratch.path().join(name);
    fs::create_dir_all(folder.join("hammers")).expect("folder");
    for file in ["placement.toml", "hammers/default.toml"] {
        fs::copy(Path::new(STUDY).with_file_name(file), folder.join(file)).expect("a copy of the study");
    }
    folder
}

/// The `decore` command that makes a sweep's tasks; the study is the copy in the output's folder.
fn cluster(command: &str, output: &Path, row_ms: &str) -> Command {
    let mut decore = decore();
    let study = output.with_file_name("placement.toml");
    decore.arg(command).arg(study).args(["--tasks", &TASKS.to_string()]).arg("--output").arg(output);
    decore.args(["--set", &format!("design.rows={ROWS}"), "--stub-row-ms", row_ms]);
    decore
}

fn undisturbed(folder: &Path) {
    expect_code(sweep(folder, ROWS, 0.0), ROWS_FAILED);
}

fn shard(output: &Path, index: u64) -> PathBuf {
    let name = output.file_name().expect("name").to_string_lossy();
    output.with_file_name(format!("{name}.shards")).join(format!("shard-{index}-of-{TASKS}"))
}

/// Waits until `ready` gives something.
fn wait_for<T>(what: &str, mut ready: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    while begin.elapsed() < PATIENCE {
        if let Some(found) = ready() {
            return found;
        }
        sleep(Duration::from_millis(200));
    }
    panic!("{what}: not within {} s", PATIENCE.as_secs());
}

/// The process that writes a shard, once it has rows in its journal.
fn working_process(shard: &Path) -> Option<u32> {
    let journal = fs::read_dir(shard.join(".journal")).ok()?;
    let of_rows = |entry: &fs::DirEntry| entry.path().extension().is_some_and(|ending| ending == "rows");
    let has_rows = journal.flatten().filter(of_rows).any(|entry| entry.metadata().is_ok_and(|data| data.len() > 2000));
    let owner = fs::read_to_string(shard.join(".lock")).ok()?;
    has_rows.then(|| owner.split_whitespace().nth(1)?.parse().ok()).flatten()
}

/// Slurm's two daemons with a configuration of their own.
struct Slurm {
    folder: TempDir,
    daemons: Vec<Child>,
}

impl Slurm {
    fn start() -> Self {
        start_munge();
        let folder = TempDir::new().expect("scratch folder");
        let host = text(Command::new("hostname").arg("-s"));
        let at = |name: &str| folder.path().join(name).display().to_string();
        for name in ["state", "spool"] {
            fs::create_dir(folder.path().join(name)).expect("folder");
        }
        let configuration = format!(
            "ClusterName=decore\nSlurmctldHost={host}(127.0.0.1)\nSlurmctldPort=16917\nSlurmdPort=16918\n\
             AuthType=auth/munge\nCredType=cred/munge\nSlurmUser=root\nSlurmdUser=root\n\
             ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSelectType=select/cons_tres\n\
             SelectTypeParameters=CR_Core\nJobAcctGatherType=jobacct_gather/none\n\
             AccountingStorageType=accounting_storage/none\nMpiDefault=none\nReturnToService=2\n\
             SchedulerParameters=sched_interval=1,bf_interval=1\nStateSaveLocation={}\nSlurmdSpoolDir={}\n\
             SlurmctldPidFile={}\nSlurmdPidFile={}\nNodeName={host} NodeAddr=127.0.0.1 CPUs=2\n\
             PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP\n",
            at("state"),
            at("spool"),
            at("slurmctld.pid"),
            at("slurmd.pid"),
        );
        fs::write(folder.path().join("slurm.conf"), configuration).expect("configuration");
        let mut slurm = Self { folder, daemons: Vec::new() };
        for daemon in ["slurmctld", "slurmd"] {
            let log = fs::File::create(slurm.folder.path().join(format!("{daemon}.log"))).expect("log");
            let mut command = slurm.command(daemon);
            command.arg("-D").stdout(Stdio::null()).stderr(log);
            slurm.daemons.push(command.spawn().expect("Slurm is installed (apt-get install slurm-wlm munge)"));
        }
        wait_for("an idle node", || text(&mut slurm.command("sinfo")).contains("idle").then_some(()));
        slurm
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("SLURM_CONF", self.folder.path().join("slurm.conf"));
        command
    }

    /// Jobs that wait or run.
    fn queue(&self) -> String {
        text(self.command("squeue").args(["--noheader", "--array", "--format=%i %j %T %r"]))
    }

    /// Kills a task and puts it back into the queue, without the two minutes for which Slurm holds it there.
    fn requeue(&self, task: &str) {
        let requeued = self.command("scontrol").args(["requeue", task]).status();
        assert!(requeued.expect("scontrol runs").success());
        wait_for("the task to be queued again", || {
            self.queue()
                .lines()
                .any(|line| line.starts_with(&format!("{task} ")) && line.contains("BeginTime"))
                .then_some(())
        });
        let released = self.command("scontrol").args(["update", &format!("JobId={task}"), "StartTime=now"]).status();
        assert!(released.expect("scontrol runs").success());
    }
}

impl Drop for Slurm {
    fn drop(&mut self) {
        for daemon in self.daemons.iter_mut().rev() {
            let _ = daemon.kill();
            let _ = daemon.wait();
        }
    }
}

/// Slurm's authentication, if it does not run yet.
fn start_munge() {
    if Command::new("munge").arg("-n").output().is_ok_and(|output| output.status.success()) {
        return;
    }
    let script = "mkdir -p /run/munge && chown munge: /run/munge && su -s /bin/sh munge -c munged";
    let started = Command::new("sh").args(["-c", script]).status();
    assert!(started.expect("sh runs").success(), "munged starts (apt-get install munge; as root)");
}

fn text(command: &mut Command) -> String {
    let output = command.output().expect("the command runs");
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

#[test]
fn a_slurm_array_with_a_killed_and_a_requeued_task_gives_the_same_bytes() {
    if std::env::var_os("DECORE_SLURM").is_none_or(|set| set != "1") {
        println!("skipped: set DECORE_SLURM=1 to run it against a real Slurm");
        return;
    }
    let scratch = TempDir::new().expect("scratch folder");
    let (whole, merged) = (scratch.path().join("whole"), study_folder(&scratch, FORGED).join("merged"));
    undisturbed(&whole);
    let slurm = Slurm::start();
    let mut submit = cluster("slurm", &merged, "20");
    submit.env("SLURM_CONF", slurm.folder.path().join("slurm.conf")).args(["--submit", "--sbatch=--time=01:00:00"]);
    let submitted = expect_code(submit, 0);
    let told = String::from_utf8_lossy(&submitted.stdout).into_owned();
    let id = told.split_whitespace().nth(1).expect("the job's number").trim_end_matches(',').to_owned();

    let first = wait_for("rows of task 1", || working_process(&shard(&merged, 1)));
    signal("KILL", first);
    wait_for("rows of task 2", || working_process(&shard(&merged, 2)));
    slurm.requeue(&format!("{id}_2"));
    wait_for("the end of all jobs", || slurm.queue().is_empty().then_some(()));

    let logs = merged.with_file_name("merged.cluster").join("logs");
    let log = |name: &str| fs::read_to_string(logs.join(name)).expect("log");
    assert!(log("task-1.log").contains("was killed (exit code 137); attempt 2"), "{}", log("task-1.log"));
    for name in ["task-1.log", "task-2.log"] {
        assert!(log(name).contains("continuing: "), "{}", log(name));
    }
    assert!(merged.join("manifest.json").exists(), "{}", log("merge.log"));
    assert_same(&whole, &merged);
}

#[test]
fn hyperqueue_with_a_killed_task_gives_the_same_bytes() {
    let Some(python) = std::env::var_os("DECORE_HYPERQUEUE") else {
        println!("skipped: set DECORE_HYPERQUEUE to a Python that has the package hyperqueue");
        return;
    };
    let scratch = TempDir::new().expect("scratch folder");
    let (whole, merged) = (scratch.path().join("whole"), study_folder(&scratch, FORGED).join("merged"));
    undisturbed(&whole);
    expect_code(cluster("hyperqueue", &merged, "5"), 0);
    let folder = merged.with_file_name("merged.cluster");
    let mut script = Command::new(python);
    script.arg(folder.join("sweep_on_hyperqueue.py")).arg("--local").current_dir(&folder);
    let mut child = script.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("Python starts");
    let third = wait_for("rows of task 3, or the script's end", || {
        let ended = child.try_wait().expect("known").is_some();
        working_process(&shard(&merged, 3)).map(Some).or(ended.then_some(None))
    });
    let Some(third) = third else {
        panic!("{}", errors(&child.wait_with_output().expect("ended")));
    };
    signal("KILL", third);
    let ended = child.wait_with_output().expect("ended");
    assert!(ended.status.success(), "{}", errors(&ended));
    let log = fs::read_to_string(folder.join("logs/task-3.log")).expect("log");
    assert!(log.contains("was killed") && log.contains("continuing: "), "{log}");
    assert_same(&whole, &merged);
}

#[test]
fn the_scripts_are_sound_and_paths_are_data() {
    let scratch = TempDir::new().expect("scratch folder");
    let merged = study_folder(&scratch, FORGED).join("it's @TASKS@ %j");
    let mut command = cluster("slurm", &merged, "0");
    command.args(["--sbatch=--partition=long", "--threads", "3"]);
    expect_code(command, 0);
    expect_code(cluster("hyperqueue", &merged, "0"), 0);
    let folder = merged.with_file_name("it's @TASKS@ %j.cluster");
    let array = fs::read_to_string(folder.join("array.sbatch")).expect("script");
    for line in [
        "#SBATCH --array=1-4",
        "#SBATCH --cpus-per-task=3",
        "#SBATCH --requeue",
        "#SBATCH --signal=B:TERM@60",
        "#SBATCH --open-mode=append",
        "#SBATCH --partition=long",
    ] {
        assert!(array.lines().any(|other| other == line), "{line} in {array}");
    }
    for name in ["array.sbatch", "merge.sbatch", "task.sh", "merge.sh", "sweep_on_hyperqueue.py"] {
        let text = fs::read_to_string(folder.join(name)).expect("script");
        assert!(!text.contains("touch forged") && !text.contains("@TASKS@"), "{name}: {text}");
    }
    for name in ["array.sbatch", "merge.sbatch", "task.sh", "merge.sh"] {
        let checked = Command::new("sh").arg("-n").arg(folder.join(name)).status();
        assert!(checked.expect("sh runs").success(), "{name}");
    }
    // The tasks work without any scheduler too.
    undisturbed(&scratch.path().join("whole"));
    for index in 1..=TASKS {
        let mut task = Command::new("sh");
        task.arg(folder.join("task.sh")).arg(index.to_string()).current_dir(scratch.path());
        expect_code(task, 0);
    }
    let mut merge = Command::new("sh");
    merge.arg(folder.join("merge.sh"));
    let ended = output(merge);
    assert_eq!(ended.status.code(), Some(0), "{}", errors(&ended));
    assert_same(&scratch.path().join("whole"), &merged);
    for place in [scratch.path(), &folder, merged.parent().expect("folder")] {
        assert!(!place.join("forged").exists(), "a path was run in {}", place.display());
    }
}

#[test]
fn control_characters_are_no_part_of_a_script() {
    let scratch = TempDir::new().expect("scratch folder");
    let folder = study_folder(&scratch, FORGED);
    let broken = study_folder(&scratch, "line\ntouch forged");
    let cases = [
        (broken.join("merged"), vec![], "--output: "),
        (folder.join("mer\nged"), vec![], "--output: "),
        (folder.join("mer\tged"), vec![], "--output: "),
        (folder.join("merged"), vec!["--sbatch", "--time=1\r"], "--sbatch: "),
        (folder.join("merged"), vec!["--set", "design.seed =\n3"], "--set: "),
        (folder.join("merged"), vec!["--sbatch", "--time=1\n#SBATCH --uid=0"], "--sbatch: "),
    ];
    for (output, further, place) in cases {
        let mut command = cluster("slurm", &output, "0");
        command.args(further);
        let told = errors(&expect_code(command, 2));
        assert!(told.contains(place) && told.contains("control character"), "{told}");
        assert!(!told.trim_end().contains('\n'), "{told}");
    }
    assert!(!folder.join("merged.cluster").exists());
    let told = errors(&expect_code(cluster("slurm", &folder.join(r"mer\ged"), "0"), 2));
    assert!(told.contains("without backslashes"), "{told}");
}
