//! Runs the binary on case folders made for one test.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

/// A command that takes this long hangs: the slowest test case takes seconds.
const HANG: Duration = Duration::from_mins(5);

/// A case folder that vanishes with the test.
pub(crate) struct Case {
    folder: TempDir,
}

impl Case {
    /// A folder with the given files.
    pub(crate) fn new(files: &[(&str, &str)]) -> Self {
        let case = Self { folder: TempDir::new().unwrap() };
        for (name, content) in files {
            case.write(name, content);
        }
        case
    }

    /// The example that `truing init` writes.
    pub(crate) fn example(kind: &str) -> Self {
        let case = Self::new(&[]);
        truing::write_example(kind, case.path()).unwrap();
        case
    }

    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.file(name), content).unwrap();
    }

    /// Replaces text that must be there.
    pub(crate) fn replace(&self, name: &str, from: &str, to: &str) {
        let text = fs::read_to_string(self.file(name)).unwrap();
        assert!(text.contains(from), "{name} has no {from}");
        self.write(name, text.replacen(from, to, 1));
    }

    pub(crate) fn run(&self, command: &str) -> Ended {
        truing(&[command, self.path().to_str().unwrap()])
    }

    /// The JSON of a command that must succeed.
    pub(crate) fn json(&self, command: &str) -> Value {
        let ended = truing(&[command, self.path().to_str().unwrap(), "--json"]);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        assert_eq!(ended.stderr, "", "--json leaves standard error alone");
        serde_json::from_str(&ended.stdout).unwrap()
    }

    /// The one message of a command that must fail with `code`.
    pub(crate) fn message(&self, command: &str, code: i32) -> String {
        let ended = self.run(command);
        assert_eq!((ended.code, ended.stdout.as_str()), (code, ""), "{}", ended.stderr);
        ended.one_message()
    }
}

/// A command that came to its end.
pub(crate) struct Ended {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Ended {
    /// The text of the error on standard error, which must hold one line and no panic.
    pub(crate) fn one_message(&self) -> String {
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        let message = self.stderr.strip_prefix("error: ").expect("a message that says «error: »");
        let message = message.strip_suffix('\n').expect("a whole line");
        assert!(!message.contains('\n'), "one line: {message}");
        assert!(!message.is_empty(), "a message that says something");
        message.to_owned()
    }
}

/// Runs the binary; a command that does not end is killed and fails the test.
pub(crate) fn truing(arguments: &[&str]) -> Ended {
    ended(Command::new(env!("CARGO_BIN_EXE_truing")).args(arguments))
}

/// Runs the binary on as many threads, however many the machine has.
pub(crate) fn truing_on(threads: usize, arguments: &[&str]) -> Ended {
    let mut command = Command::new(env!("CARGO_BIN_EXE_truing"));
    ended(command.args(arguments).env("RAYON_NUM_THREADS", threads.to_string()))
}

fn ended(command: &mut Command) -> Ended {
    let folder = TempDir::new().unwrap();
    let (out, err) = (folder.path().join("out"), folder.path().join("err"));
    let mut child = command
        .stdin(Stdio::null())
        .stdout(fs::File::create(&out).unwrap())
        .stderr(fs::File::create(&err).unwrap())
        .spawn()
        .unwrap();
    let started = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if started.elapsed() > HANG {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("{command:?} hangs");
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    Ended {
        code: status.code().expect("not ended by a signal"),
        stdout: fs::read_to_string(out).unwrap(),
        stderr: fs::read_to_string(err).unwrap(),
    }
}
