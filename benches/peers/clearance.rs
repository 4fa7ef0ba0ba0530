//! The benchmark contestant that measures this library, through its public interface only: command loop over stdin.
//!
//! `python3 benches/peers/run.py` starts it and speaks to it over lines of tab-separated words; `README.md` beside it
//! has the words. It also prepares what all contestants are asked about: it reads robots and meshes, draws states and
//! poses, and writes them down in a neutral form.

#[path = "clearance/among.rs"]
mod among;
#[path = "clearance/answer.rs"]
mod answer;
#[path = "clearance/batch_and_stream.rs"]
mod batch_and_stream;
#[path = "clearance/certificates.rs"]
mod certificates;
#[path = "clearance/edges.rs"]
mod edges;
#[path = "clearance/mesh_pair.rs"]
mod mesh_pair;
#[path = "clearance/neutral.rs"]
mod neutral;
#[path = "clearance/random.rs"]
mod random;
#[path = "clearance/sample_states.rs"]
mod sample_states;
#[path = "clearance/scatter.rs"]
mod scatter;
#[path = "clearance/surroundings.rs"]
mod surroundings;
#[path = "clearance/volume_cost_model.rs"]
mod volume_cost_model;
#[path = "clearance/whole_robot.rs"]
mod whole_robot;
#[path = "clearance/world_file.rs"]
mod world_file;

use std::error::Error;
use std::hint::black_box;
use std::io::{BufRead, Write};
use std::path::Path;

use answer::Answer;
use cpu_time::ProcessTime;
use mesh_pair::MeshPair;
use whole_robot::WholeRobot;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// What the questions are about.
enum Subject {
    Robot(Box<WholeRobot>),
    Meshes(Box<MeshPair>),
}

impl Subject {
    /// Asks `question` about every state or edge of `set`; false where the library has no call for it.
    fn ask(&mut self, question: &str, set: &str, hear: impl FnMut(Answer)) -> Outcome<bool> {
        match self {
            Self::Robot(robot) => robot.ask(question, set, hear),
            Self::Meshes(pair) => pair.ask(question, set, hear),
        }
    }
}

fn main() -> Outcome<()> {
    if std::env::args().nth(1).as_deref() != Some("serve") {
        eprintln!("this only serves the comparison with other libraries: python3 benches/peers/run.py");
        return Ok(());
    }
    let mut subject = None;
    for line in std::io::stdin().lock().lines() {
        let reply = match reply(&line?, &mut subject) {
            Ok(Some(words)) => format!("ok\t{words}"),
            Ok(None) => "unsupported".to_owned(),
            Err(error) => format!("error\t{}", error.to_string().replace(['\n', '\t'], " ")),
        };
        let mut out = std::io::stdout().lock();
        writeln!(out, "{reply}")?;
        out.flush()?;
    }
    Ok(())
}

/// What one line of the protocol is answered with; `None` if that cannot be asked of this library.
fn reply(line: &str, subject: &mut Option<Subject>) -> Outcome<Option<String>> {
    let words: Vec<&str> = line.split('\t').collect();
    match (&words[..], subject.as_mut()) {
        (["robot", source @ ..], _) => {
            let robot = WholeRobot::prepare(source)?;
            let summary = robot.summary();
            *subject = Some(Subject::Robot(Box::new(robot)));
            Ok(Some(summary))
        }
        (["meshes", a, b, seed, count, out], _) => {
            let pair = MeshPair::prepare(a, b, seed.parse()?, count.parse()?, out)?;
            let summary = pair.summary();
            *subject = Some(Subject::Meshes(Box::new(pair)));
            Ok(Some(summary))
        }
        (["edges", file], Some(Subject::Robot(robot))) => {
            robot.take_edges(Path::new(file))?;
            Ok(Some(String::new()))
        }
        (["world" | "scatter" | "growth" | "latency", ..], Some(Subject::Robot(robot))) => {
            robot.surround(&words)
        }
        (["certificates", set], Some(Subject::Robot(robot))) => robot.certificate_costs(set),
        (["pass", question, set, repeats], Some(subject)) => {
            let repeats: u32 = repeats.parse()?;
            let start = ProcessTime::now();
            for _ in 0..repeats {
                if !subject.ask(question, set, |answer| drop(black_box(answer)))? {
                    return Ok(None);
                }
            }
            Ok(Some(start.elapsed().as_nanos().to_string()))
        }
        (["answers", question, set], Some(subject)) => {
            let mut answers = Vec::new();
            let known = subject.ask(question, set, |answer| answers.push(answer))?;
            let words: Vec<String> = answers.iter().map(ToString::to_string).collect();
            Ok(known.then(|| words.join("\t")))
        }
        (["figures"], Some(Subject::Robot(robot))) => Ok(Some(robot.figures()?)),
        (["costs"], Some(Subject::Meshes(pair))) => Ok(Some(pair.costs())),
        _ => Err(format!("cannot make sense of '{line}'").into()),
    }
}
