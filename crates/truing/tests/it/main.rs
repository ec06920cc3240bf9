//! The command line and the facade, from case folders to answers and exit codes.

#![expect(
    clippy::format_push_string,
    clippy::format_collect,
    reason = "short tables are put together where speed is nothing"
)]
#![expect(clippy::unwrap_used, reason = "helpers of tests, not marked as tests themselves")]

mod affine_frame;
mod answers;
mod carry;
mod columns;
mod command;
mod conformity;
mod correct;
mod depth;
mod examples;
mod files;
mod force_impedance_messages;
mod form_map;
mod ft_center_messages;
mod fuzzed;
mod groups;
mod growth;
mod guide;
mod hostile;
mod hostile_forms;
mod import;
mod import_step;
mod import_table;
mod itlicp;
mod judged;
mod linuxcnc;
mod machine;
mod messages;
mod met_by_all;
mod monitor;
mod monte_carlo;
mod nurbs;
mod odd_check;
mod plan;
mod pose_icp;
mod pose_icp_messages;
mod positioning;
mod probe_comp_messages;
mod probe_qualification;
mod readers;
mod reading;
mod register;
mod repeats;
mod saved_frame;
mod set_ups;
mod shell;
mod shown;
mod suspects;
mod tables;
mod threads;
mod tracker_head;
mod tracker_lm;
mod tracker_targets;
