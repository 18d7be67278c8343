//! The command line: arguments, messages and exit codes. What a subcommand does stands in its own file.
//!
//! Results go to standard output, with `--json` as exactly one object; everything else goes to standard error.
//! Exit codes: 0 done, 1 findings, 2 unusable input or arguments, 130 interrupted.

pub mod check;
pub mod compare;
pub mod converge;
pub mod convert;
pub mod diff;
pub mod features;
mod interrupt;
pub mod library;
mod library_check;
mod material_argument;
pub mod merge;
pub mod parity;
pub mod presets;
mod progress_line;
pub mod render;
mod repeat;
pub mod scene_options;
mod set;
pub mod shader;
pub mod stability;
pub(crate) mod suggest;
mod target;
pub mod turntable;
mod window;

use crate::app::WindowOptions;
use crate::offline::OfflineError;
use clap::{Parser, Subcommand};
use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// A material editor for the Adobe Standard Material 4.0.
///
/// Without a subcommand it opens the editor; with no display it renders the default scene to burnish.png instead.
#[derive(Debug, Parser)]
#[command(name = "burnish", version, args_conflicts_with_subcommands = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    /// Materials, meshes, environments or folders to open
    files: Vec<PathBuf>,
    /// Saves a picture of the window once it shows something, and closes it
    #[arg(long, value_name = "FILE", hide = true)]
    screenshot: Option<PathBuf>,
    /// Gives the graphics device up after this long, as a crashing driver does
    #[arg(long, value_name = "SECONDS", hide = true)]
    lose_device: Option<f64>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Renders one picture
    Render(Box<render::RenderArguments>),
    /// Measures error against run time
    Converge(Box<converge::ConvergeArguments>),
    /// Tells how far a picture is from another
    Compare(compare::CompareArguments),
    /// Tells how far the preview is from the final view, and which property explains it
    Parity(Box<parity::ParityArguments>),
    /// Lists, shows and searches the built-in materials
    Presets(presets::PresetsArguments),
    /// Checks material files, or all in a folder: whether they can be read, and what is hardly meant
    Check(check::CheckArguments),
    /// Writes a material in another format, and tells what that costs
    Convert(Box<convert::ConvertArguments>),
    /// Lists what two materials differ in, value by value
    Diff(Box<diff::DiffArguments>),
    /// Puts two versions of a material together that were made from a third
    Merge(merge::MergeArguments),
    /// Reports which lobes a material needs, and what leaving out the others saves
    Features(Box<features::FeaturesArguments>),
    /// A folder of materials as a library: what is in it, small pictures of it, and whether it can be handed out
    Library(library::LibraryArguments),
    /// Writes the material's BSDF as shader code with only the lobes that it needs
    Shader(shader::ShaderArguments),
    /// Renders an image sequence around the object
    Turntable(Box<turntable::TurntableArguments>),
    /// Probes materials numerically at extremes; without one, the built-in suite
    Stability(Box<stability::StabilityArguments>),
}

/// How a command ended that did what it was asked to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Done, or everything checked holds.
    Done,
    /// A check does not hold.
    Findings,
}

/// Why a command did not do what it was asked to do.
#[derive(Debug)]
pub enum CliError {
    /// Input or arguments cannot be used: one line with the file, the key and what was expected.
    Unusable(String),
    /// The user interrupted it; nothing was written.
    Interrupted,
    /// The user interrupted it; what was written, and how it goes on.
    Stopped(String),
}

impl CliError {
    /// An error with this sentence.
    pub fn unusable(message: impl fmt::Display) -> Self {
        Self::Unusable(message.to_string())
    }
}

impl From<OfflineError> for CliError {
    fn from(error: OfflineError) -> Self {
        let option = match &error {
            OfflineError::Cancelled => return Self::Interrupted,
            OfflineError::NotOfPreview => {
                let expected = "expected no --transparent, --aov, --error or --denoise; they belong to --view final";
                return Self::Unusable(format!("--view preview: {expected}"));
            }
            OfflineError::HasTurntable { .. } => return Self::Unusable(format!("{error}, or --resume to go on with this one")),
            OfflineError::TooLarge { .. } => "--size: ",
            OfflineError::Preview(_) => "--view preview: ",
            OfflineError::Denoise(_) => "--denoise: ",
            OfflineError::Folder { .. } => "--out: ",
            OfflineError::Export(_) | OfflineError::Unusable(_) => "",
        };
        Self::Unusable(format!("{option}{error}"))
    }
}

impl fmt::Display for CliError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unusable(message) | Self::Stopped(message) => f.write_str(message),
            Self::Interrupted => f.write_str("interrupted; nothing was written"),
        }
    }
}

impl std::error::Error for CliError {}

/// Warnings of one command: printed as they come, and kept for the JSON object.
#[derive(Debug, Default)]
pub struct Messages {
    warnings: Vec<String>,
}

impl Messages {
    /// Prints a warning on standard error; the same sentence only once.
    pub fn warn(&mut self, message: impl Into<String>) {
        let message = message.into();
        if !self.warnings.contains(&message) {
            eprintln!("warning: {}", one_line(&message));
            self.warnings.push(message);
        }
    }

    /// Prints a warning about a file, which is named first unless the sentence does so itself.
    pub fn warn_about(&mut self, file: &Path, message: &str) {
        let file = file.display().to_string();
        self.warn(if message.starts_with(&file) { message.to_owned() } else { format!("{file}: {message}") });
    }

    /// Everything said so far.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

/// Runs the program with the arguments of the process.
pub fn main() -> ExitCode {
    let words: Vec<_> = std::env::args_os().collect();
    let arguments = match Arguments::try_parse_from(words) {
        Ok(arguments) => arguments,
        Err(error) if error.use_stderr() => return exit(Err(CliError::Unusable(sentence_of(&error)))),
        // Help and version are what was asked for, so they are no error and belong to standard output.
        Err(text) => return exit(print_out(&text.to_string()).map(|()| Outcome::Done)),
    };
    exit(match arguments.command {
        None => {
            let loses_device_after = arguments.lose_device.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
            window::run(arguments.files, &WindowOptions { screenshot: arguments.screenshot, loses_device_after })
        }
        Some(command) => {
            interrupt::listen();
            match command {
                Command::Render(arguments) => render::run(&arguments),
                Command::Converge(arguments) => converge::run(&arguments),
                Command::Compare(arguments) => compare::run(&arguments),
                Command::Parity(arguments) => parity::run(&arguments),
                Command::Presets(arguments) => presets::run(&arguments),
                Command::Check(arguments) => check::run(&arguments),
                Command::Convert(arguments) => convert::run(&arguments),
                Command::Diff(arguments) => diff::run(&arguments),
                Command::Merge(arguments) => merge::run(&arguments),
                Command::Features(arguments) => features::run(&arguments),
                Command::Library(arguments) => library::run(&arguments),
                Command::Shader(arguments) => shader::run(&arguments),
                Command::Turntable(arguments) => turntable::run(&arguments),
                Command::Stability(arguments) => stability::run(&arguments),
            }
        }
    })
}

fn exit(result: Result<Outcome, CliError>) -> ExitCode {
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Findings) => ExitCode::from(1),
        Err(error) => {
            eprintln!("error: {}", one_line(&error.to_string()));
            ExitCode::from(if matches!(error, CliError::Interrupted | CliError::Stopped(_)) { 130 } else { 2 })
        }
    }
}

/// What clap says, in one line: the fault and its tip, without the usage.
fn sentence_of(error: &clap::Error) -> String {
    let text = error.to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let paragraphs = text.split("\n\n").filter(|part| !part.starts_with("Usage:") && !part.starts_with("For more information"));
    let sentence = one_line(&paragraphs.collect::<Vec<_>>().join("; "));
    format!("{sentence}; see --help")
}

/// The text with every run of white space and line ends as one space, so that a message stays in its line.
pub(crate) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Writes to standard output. A reader that has gone away is no fault of ours.
fn print_out(text: &str) -> Result<(), CliError> {
    let mut out = std::io::stdout().lock();
    let end = if text.ends_with('\n') { "" } else { "\n" };
    match write!(out, "{text}{end}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(CliError::unusable(format!("standard output: cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_declared_arguments_are_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn usage_errors_are_one_line() {
        for words in [
            &["burnish", "render", "--spp", "x"][..],
            &["burnish", "render", "m"],
            &["burnish", "--sed"],
            &["burnish", "presets"],
        ] {
            let error = Arguments::try_parse_from(words).unwrap_err();
            let sentence = sentence_of(&error);
            assert!(!sentence.contains('\n') && sentence.len() > 20, "{sentence}");
        }
    }
}
