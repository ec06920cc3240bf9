//! `truing monitor`: a stream on standard input or of datagrams.

use std::io::{self, BufRead};
use std::net::{SocketAddr, UdpSocket};
use std::path::PathBuf;

use clap::Args;
use truing::{Case, Error, PathMonitor, PathMonitorOptions, StreamTable};

use super::number::positive;
use super::output;

#[derive(Args, Debug)]
pub(crate) struct Live {
    /// Case folder of kind ft-center with presses, or with a frame solved before: where the sensor
    /// is, the height of the contact plane, and the force from which on the head touches
    pub(crate) case: PathBuf,
    /// Distance from the commanded path at which the contact counts as left, mm
    #[arg(long, value_name = "MM", value_parser = positive)]
    tolerance: f64,
    /// Time constant of the low pass, several turns of the spindle, s
    #[arg(long, value_name = "S", default_value_t = 2.0, value_parser = positive)]
    filter: f64,
    /// Take datagrams at this address in place of standard input; an empty one ends the stream
    #[arg(long, value_name = "ADDRESS:PORT")]
    udp: Option<SocketAddr>,
    /// Print one JSON object a line
    #[arg(long)]
    json: bool,
}

/// Largest datagram that there is.
const MOST_BYTES: usize = 1 << 16;

pub(crate) fn monitor(live: &Live, case: &Case) -> Result<(), Error> {
    let options = PathMonitorOptions { tolerance_mm: live.tolerance, filter_s: live.filter };
    let mut stream = Stream {
        monitor: PathMonitor::new(case, options)?,
        table: StreamTable::default(),
        lines: 0,
        json: live.json,
    };
    match live.udp {
        Some(address) => stream.datagrams(address)?,
        None => stream.standard_input()?,
    }
    if live.json {
        output::line(stream.monitor.summary())
    } else {
        output::text(stream.monitor.summary())
    }
}

struct Stream {
    monitor: PathMonitor,
    table: StreamTable,
    lines: usize,
    json: bool,
}

impl Stream {
    fn standard_input(&mut self) -> Result<(), Error> {
        for line in io::stdin().lock().lines() {
            self.line(&line.map_err(|e| Error::Stream { reason: e.kind() })?)?;
        }
        Ok(())
    }

    fn datagrams(&mut self, address: SocketAddr) -> Result<(), Error> {
        let fail = |e: io::Error| Error::Stream { reason: e.kind() };
        let socket = UdpSocket::bind(address).map_err(fail)?;
        let bound = socket.local_addr().map_err(fail)?;
        // Where any port will do, somebody has to be told which one it is.
        output::notes(&[format!("listening at {bound}")]);
        let mut buffer = vec![0; MOST_BYTES];
        loop {
            let (length, _) = socket.recv_from(&mut buffer).map_err(fail)?;
            if length == 0 {
                return Ok(());
            }
            let text = String::from_utf8_lossy(&buffer[..length]).into_owned();
            for line in text.lines() {
                self.line(line)?;
            }
        }
    }

    /// A header, a comment, or a row; a line that is none of them ends nothing.
    fn line(&mut self, line: &str) -> Result<(), Error> {
        self.lines += 1;
        let line = line.trim_start_matches('\u{feff}').trim();
        if line.is_empty() || line.starts_with('#') {
            return Ok(());
        }
        let failed = |problem| Error::StreamRow { line: self.lines, problem };
        if StreamTable::is_header(line) {
            self.table = StreamTable::of_header(line).map_err(failed)?;
            return Ok(());
        }
        match self.table.row(line) {
            Ok(row) => match self.monitor.update(&row) {
                Some(event) if self.json => output::line(&event),
                Some(event) => output::text(&event),
                None => Ok(()),
            },
            // A monitor of a machine goes on.
            Err(problem) => {
                output::warnings(&[failed(problem).to_string()]);
                Ok(())
            }
        }
    }
}
