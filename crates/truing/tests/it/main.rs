//! The command line and the facade, from case folders to answers and exit codes.

mod answers;
mod command;
mod examples;
mod ft_center_messages;
mod groups;
mod hostile;
mod messages;
mod reading;
