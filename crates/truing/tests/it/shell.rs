//! What a shell and a manual know of the program.

use crate::command::truing;

const COMMANDS: [&str; 12] = [
    "solve",
    "loop",
    "check",
    "plan",
    "register",
    "correct",
    "index",
    "design",
    "import",
    "init",
    "completions",
    "man",
];

#[test]
fn completions_know_every_command() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let ended = truing(&["completions", shell]);
        assert_eq!((ended.code, ended.stderr.as_str()), (0, ""), "{shell}");
        for command in COMMANDS {
            assert!(ended.stdout.contains(command), "{shell} does not know {command}");
        }
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let program = truing(&["man"]);
    assert_eq!((program.code, program.stderr.as_str()), (0, ""));
    for command in COMMANDS {
        assert!(program.stdout.contains(command), "the program's page leaves out {command}");
        let page = truing(&["man", command]);
        assert_eq!((page.code, page.stderr.as_str()), (0, ""), "{command}");
        assert!(page.stdout.contains(".TH truing"), "{command}: {}", page.stdout);
        assert!(page.stdout.contains(".SH SYNOPSIS"), "{command}: {}", page.stdout);
    }
    let refused = truing(&["man", "lop"]);
    assert_eq!(refused.code, 2);
    assert!(refused.stderr.contains("the commands are solve, loop"), "{}", refused.stderr);
}

#[test]
fn help_lists_the_kinds() {
    for arguments in [&["--help"][..], &["init", "--help"]] {
        let help = truing(arguments).stdout;
        for (kind, summary) in truing::examples() {
            assert!(help.contains(kind) && help.contains(summary), "{arguments:?}: {help}");
        }
    }
}
