//! Case folders damaged at random: each must end in an answer or in one message.

use std::fs;
use std::path::Path;
use std::sync::mpsc;
use std::time::Duration;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use truing::{check, close_loop, read_case, solve};

use crate::command::truing;
use crate::hostile_forms::{FORMS, whole};

/// Far beyond the slowest case of a few dozen points; what takes longer hangs.
const HANG: Duration = Duration::from_mins(2);

/// Values that break something somewhere.
const POISON: [&str; 24] = [
    "",
    "nan",
    "inf",
    "-inf",
    "1e300",
    "-1e300",
    "1e999",
    "1e-300",
    "0",
    "-0",
    "-1",
    "1e11",
    "1e-11",
    "x",
    "\"",
    "\"a\nb\"",
    "1,5",
    "0x10",
    "99999999999999999999999",
    "#",
    "\u{feff}",
    "\u{202e}7",
    " ",
    "fit",
];

/// One way to damage a file; the numbers choose where.
#[derive(Clone, Copy, Debug)]
enum Damage {
    Truncate,
    Empty,
    Delete,
    BecomeFolder,
    InsertByte,
    NotUtf8,
    Poison,
    PoisonColumn,
    ScaleColumn,
    SwapNames,
    RenameUnit,
    DuplicateLine,
    DeleteLine,
    DeleteManyLines,
    Crlf,
    Bom,
    ManyColumns,
    CovariateOfNoise,
    ShuffleLines,
}

const ALL: [Damage; 19] = [
    Damage::Truncate,
    Damage::Empty,
    Damage::Delete,
    Damage::BecomeFolder,
    Damage::InsertByte,
    Damage::NotUtf8,
    Damage::Poison,
    Damage::PoisonColumn,
    Damage::ScaleColumn,
    Damage::SwapNames,
    Damage::RenameUnit,
    Damage::DuplicateLine,
    Damage::DeleteLine,
    Damage::DeleteManyLines,
    Damage::Crlf,
    Damage::Bom,
    Damage::ManyColumns,
    Damage::CovariateOfNoise,
    Damage::ShuffleLines,
];

/// Where a damage strikes; every number is taken modulo what there is.
#[derive(Clone, Copy, Debug)]
struct Strike {
    damage: Damage,
    file: usize,
    line: usize,
    column: usize,
    value: usize,
}

impl Strike {
    fn on(self, folder: &Path) {
        let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|f| f.unwrap().path()).collect();
        files.retain(|f| f.is_file());
        files.sort();
        let Some(path) = files.get(self.file % files.len().max(1)) else { return };
        let bytes = fs::read(path).unwrap();
        let text = String::from_utf8_lossy(&bytes).into_owned();
        match self.damage {
            Damage::Empty => fs::write(path, "").unwrap(),
            Damage::Delete => fs::remove_file(path).unwrap(),
            Damage::BecomeFolder => {
                fs::remove_file(path).unwrap();
                fs::create_dir(path).unwrap();
            }
            Damage::Truncate => {
                fs::write(path, &bytes[..self.at(bytes.len())]).unwrap();
            }
            Damage::InsertByte | Damage::NotUtf8 => {
                let at = self.at(bytes.len());
                let byte = if matches!(self.damage, Damage::NotUtf8) { 0xff } else { self.byte() };
                fs::write(path, [&bytes[..at], &[byte], &bytes[at..]].concat()).unwrap();
            }
            Damage::Bom => fs::write(path, [b"\xef\xbb\xbf", &bytes[..]].concat()).unwrap(),
            Damage::Crlf => fs::write(path, text.replace('\n', "\r\n")).unwrap(),
            _ if path.extension().is_some_and(|e| e == "toml") => {
                fs::write(path, self.on_settings(&text)).unwrap();
            }
            _ => fs::write(path, self.on_table(&text)).unwrap(),
        }
    }

    fn at(self, length: usize) -> usize {
        (self.line * 7919 + self.column) % (length + 1)
    }

    fn byte(self) -> u8 {
        u8::try_from(self.value % 256).unwrap()
    }

    fn poison(self) -> &'static str {
        POISON[self.value % POISON.len()]
    }

    /// Replaces a value, or a line, of `case.toml`.
    fn on_settings(self, text: &str) -> String {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let keys: Vec<usize> = (0..lines.len()).filter(|l| lines[*l].contains(" = ")).collect();
        let Some(line) = keys.get(self.line % keys.len().max(1)) else { return text.to_owned() };
        let (key, _) = lines[*line].split_once(" = ").unwrap();
        let key = key.trim_start_matches("# ").to_owned();
        match self.damage {
            Damage::DuplicateLine => lines.insert(*line, lines[*line].clone()),
            Damage::DeleteLine => drop(lines.remove(*line)),
            Damage::RenameUnit => lines[*line] = lines[*line].replace("_mm", "_um"),
            _ => lines[*line] = format!("{key} = {}", self.poison()),
        }
        lines.join("\n")
    }

    /// Works on the cells of a table; comments are left out.
    fn on_table(self, text: &str) -> String {
        let mut rows: Vec<Vec<String>> = text
            .lines()
            .filter(|line| !line.starts_with('#'))
            .map(|line| line.split(',').map(str::to_owned).collect())
            .collect();
        let n_rows = rows.len();
        if n_rows < 2 || rows[0].is_empty() {
            return text.to_owned();
        }
        let row = 1 + self.line % (n_rows - 1);
        let column = self.column % rows[0].len();
        let other = self.value % rows[0].len();
        match self.damage {
            Damage::Poison => set(&mut rows[row], column, self.poison()),
            Damage::PoisonColumn => {
                rows[1..].iter_mut().for_each(|row| set(row, column, self.poison()));
            }
            Damage::ScaleColumn => {
                let factor = [1e9, 1e-9, 0.0, -1.0, 1e6, 1.1][self.value % 6];
                for cell in rows[1..].iter_mut().filter_map(|row| row.get_mut(column)) {
                    if let Ok(value) = cell.parse::<f64>() {
                        *cell = format!("{}", value * factor);
                    }
                }
            }
            Damage::SwapNames => rows[0].swap(column, other),
            Damage::RenameUnit => {
                let name = &mut rows[0][column];
                *name = name.replace("_mm", "_um").replace("_n", "_kn").replace("_s", "_ms");
            }
            Damage::DuplicateLine => rows.insert(row, rows[row].clone()),
            Damage::DeleteLine => drop(rows.remove(row)),
            Damage::DeleteManyLines => rows.truncate(2 + self.line % 4),
            Damage::ManyColumns => {
                let many = [3, 40, 511, 600][self.value % 4];
                for (r, row) in rows.iter_mut().enumerate() {
                    row.extend((0..many).map(|c| match r {
                        0 => format!("extra_{c}"),
                        _ => format!("{}", (r * 31 + c * 17) % 97),
                    }));
                }
            }
            Damage::CovariateOfNoise => {
                let poison = self.poison();
                for (r, row) in rows.iter_mut().enumerate() {
                    row.push(match r {
                        0 => "load_n".to_owned(),
                        r if r == 1 + self.line % 5 => poison.to_owned(),
                        _ => format!("{}", (r * 7919) % 101),
                    });
                }
            }
            Damage::ShuffleLines => rows[1..].sort_by_key(|row| {
                row.iter().flat_map(|cell| cell.bytes()).fold(self.value, |hash, byte| {
                    (hash.wrapping_mul(31) + usize::from(byte)) % 1_000_003
                })
            }),
            _ => {}
        }
        rows.iter().map(|row| row.join(",") + "\n").collect()
    }
}

fn set(row: &mut [String], column: usize, value: &str) {
    if let Some(cell) = row.get_mut(column) {
        value.clone_into(cell);
    }
}

fn strikes() -> impl Strategy<Value = Vec<Strike>> {
    let strike = (0..ALL.len(), any::<[u16; 4]>()).prop_map(|(damage, [f, l, c, v])| Strike {
        damage: ALL[damage],
        file: f.into(),
        line: l.into(),
        column: c.into(),
        value: v.into(),
    });
    proptest::collection::vec(strike, 1..4)
}

/// What every command must come to, run in this process.
fn ends_well(folder: &Path) {
    let (done, ended) = mpsc::channel();
    let folder = folder.to_owned();
    let thread = std::thread::spawn(move || {
        let results = match read_case(&folder) {
            Err(e) => vec![Err(e)],
            Ok(case) => vec![
                solve(&case).map(|a| serde_json::to_string(&a).unwrap()),
                check(&case).map(|a| serde_json::to_string(&a).unwrap()),
                close_loop(&case).map(|a| serde_json::to_string(&a).unwrap()),
            ],
        };
        for result in results {
            match result {
                Ok(json) => assert!(json.starts_with("{\"kind\":")),
                Err(error) => {
                    let message = error.to_string();
                    assert!(message.len() > 10 && message.len() < 3000, "{message}");
                    assert!(matches!(error.exit_code(), 2 | 3));
                }
            }
        }
        done.send(()).unwrap();
    });
    match ended.recv_timeout(HANG) {
        Ok(()) => thread.join().unwrap(),
        Err(mpsc::RecvTimeoutError::Disconnected) => {
            std::panic::resume_unwind(thread.join().unwrap_err());
        }
        Err(mpsc::RecvTimeoutError::Timeout) => panic!("it hangs"),
    }
}

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(7),
        failure_persistence: None,
        max_shrink_iters: 200,
        ..ProptestConfig::default()
    }
}

#[test]
fn the_forms_are_whole_before_they_are_damaged() {
    for form in 0..FORMS {
        let case = whole(form);
        for command in ["solve", "check", "loop"] {
            let ended = case.run(command);
            assert_eq!(ended.code, 0, "{command} of form {form}: {}", ended.stderr);
        }
    }
}

proptest! {
    #![proptest_config(config(300))]

    #[test]
    fn damaged_cases_end_well(form in 0..FORMS, strikes in strikes()) {
        let case = whole(form);
        for strike in strikes {
            strike.on(case.path());
        }
        ends_well(case.path());
    }
}

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn the_binary_ends_with_a_code_of_the_contract(form in 0..FORMS, strikes in strikes()) {
        let case = whole(form);
        for strike in strikes {
            strike.on(case.path());
        }
        for command in ["solve", "loop", "check"] {
            let ended = truing(&[command, case.path().to_str().unwrap(), "--json"]);
            match ended.code {
                0 => {
                    prop_assert_eq!(&ended.stderr, "");
                    let answer: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
                    prop_assert!(answer.is_object());
                }
                2 | 3 => {
                    prop_assert_eq!(&ended.stdout, "");
                    ended.one_message();
                }
                code => prop_assert!(false, "exit code {}", code),
            }
        }
    }
}
