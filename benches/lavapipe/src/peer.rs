//! Client of a drawing process.

use crate::clock::Times;
use crate::ours::Picture;
use crate::serve::DrawSet;
use anyhow::{Context, Result};
use std::ffi::OsString;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The driver's variable for its number of rasterizer threads. With 0 its command thread rasterizes.
const DRIVER_THREADS: &str = "LP_NUM_THREADS";

/// A drawing process with its pipes.
pub(crate) struct Peer {
    /// Number of cores that it may use.
    pub(crate) cores: usize,
    /// Name of the driver.
    pub(crate) driver: String,
    process: Child,
    /// Closed to end the process.
    commands: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

/// Cost of a picture.
#[derive(Clone, Copy, Default)]
pub(crate) struct Cost {
    pub(crate) times: Times,
    pub(crate) triangles: u64,
    pub(crate) draws: u64,
}

impl Peer {
    /// Starts this program again as a drawing process with `cores` of `all` cores.
    pub(crate) fn start(arguments: &[OsString], cores: usize, all: usize) -> Result<Peer> {
        let mut command = Command::new(std::env::current_exe()?);
        command
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        if cores == 1 {
            command.env(DRIVER_THREADS, "0");
        } else {
            anyhow::ensure!(
                cores == all,
                "the driver uses one core or all, not {cores} of {all}"
            );
            command.env_remove(DRIVER_THREADS);
        }
        // Without it the driver prints a warning, though no window is needed.
        if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
            command.env("XDG_RUNTIME_DIR", std::env::temp_dir());
        }
        let mut process = command.spawn()?;
        let commands = process.stdin.take();
        let mut answers = BufReader::new(
            process
                .stdout
                .take()
                .context("the drawing process has no standard output")?,
        );
        let mut driver = String::new();
        answers.read_line(&mut driver)?;
        anyhow::ensure!(
            !driver.is_empty(),
            "the drawing process failed to start; its error is above"
        );
        Ok(Peer {
            cores,
            driver: driver.trim().to_owned(),
            process,
            commands,
            answers,
        })
    }

    /// Draws a view.
    pub(crate) fn draw(&mut self, draw_set: DrawSet, view: usize) -> Result<Cost> {
        self.send(&format!("draw {} {view}", draw_set.name()))?;
        let mut line = String::new();
        self.answers.read_line(&mut line)?;
        let mut numbers = line.split_whitespace();
        let mut next = || numbers.next().context("the drawing process has stopped");
        Ok(Cost {
            times: [next()?.parse()?, next()?.parse()?],
            triangles: next()?.parse()?,
            draws: next()?.parse()?,
        })
    }

    /// Returns the last picture.
    pub(crate) fn picture(&mut self, size: [u32; 2]) -> Result<Picture> {
        self.send("picture")?;
        let mut bytes = vec![0; 3 * size[0] as usize * size[1] as usize];
        self.answers.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    fn send(&mut self, line: &str) -> Result<()> {
        let commands = self
            .commands
            .as_mut()
            .context("the drawing process has been closed")?;
        writeln!(commands, "{line}")?;
        Ok(commands.flush()?)
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // The process ends when its standard input is closed.
        self.commands = None;
        // If it failed, it has already printed the error.
        let _ = self.process.wait();
    }
}
