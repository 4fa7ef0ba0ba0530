//! Parses the text of state files: CSV, JSON, or the YAML of ROS messages.

use std::path::Path;
use std::sync::Arc;

use clearance::robot::RobotModel;
use clearance::scene::{NamedState, StateList};

/// Accepted formats, for the error about other formats.
const STATES: &str = concat!(
    r#"states are JSON {"joints": [...], "states": [[...], ...]}, the YAML of a sensor_msgs/JointState or moveit_msgs/RobotState, "#,
    "or CSV with a header of joint names in FILE.csv"
);

/// Parses states from a text; the file extension determines whether it is CSV.
pub fn read(path: &Path, text: &str, robot: &RobotModel) -> Result<StateList, String> {
    if (path.extension()).is_some_and(|e| e.eq_ignore_ascii_case("csv")) {
        let states = from_csv(text, robot)?;
        return Ok(StateList { states, ..StateList::default() });
    }
    NamedState::list_from_text(text, robot).map_err(|why| format!("{why}; {STATES}"))
}

fn from_csv(text: &str, robot: &RobotModel) -> Result<Vec<NamedState>, String> {
    let text = text.trim_start_matches('\u{feff}');
    if text.trim().is_empty() {
        return Err(format!("it is empty: {}", header_of(robot)));
    }
    // records that are too short or too long get an error message below
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(text.as_bytes());
    let header = reader.headers().map_err(|e| e.to_string())?.clone();
    check_header(&header, robot)?;
    let joints: Arc<[String]> = header.iter().map(str::to_owned).collect();
    let mut states = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| e.to_string())?;
        let of_line = |why: String| format!("line {}: {why}", line_of(&record, text));
        if record.len() != joints.len() {
            let hint = separator_hint(&record, robot).unwrap_or_default();
            return Err(of_line(format!("{} values for {} joints{hint}", record.len(), joints.len())));
        }
        let values = record.iter().map(|field| {
            field.parse::<f64>().map_err(|_| {
                let hint = separator_hint(&record, robot).unwrap_or_default();
                of_line(format!("'{field}' is not a number{hint}"))
            })
        });
        states.push(NamedState::of_joints(Arc::clone(&joints), values.collect::<Result<_, _>>()?)?);
    }
    Ok(states)
}

/// Line number of a record, starting at 1. The reader's own number is the one before any blank lines.
fn line_of(record: &csv::StringRecord, text: &str) -> usize {
    let byte = record.position().and_then(|position| usize::try_from(position.byte()).ok()).unwrap_or(0);
    let (before, rest) = text.split_at_checked(byte).unwrap_or((text, ""));
    let blank = &rest[..rest.len() - rest.trim_start_matches(['\r', '\n']).len()];
    1 + before.matches('\n').count() + blank.matches('\n').count()
}

/// Checks that the first line contains joint names, separated by commas.
fn check_header(header: &csv::StringRecord, robot: &RobotModel) -> Result<(), String> {
    let is_number = |field: &str| field.parse::<f64>().is_ok() && !is_name(field, robot);
    if header.iter().any(|field| field == "%time" || field.starts_with("field.")) {
        return Err("line 1 is that of `rostopic echo -p`: save the message without -p, as YAML".to_owned());
    }
    if let Some(hint) = separator_hint(header, robot) {
        return Err(format!("line 1{hint}"));
    }
    if header.iter().all(is_number) {
        return Err(format!("line 1 has numbers only: {}", header_of(robot)));
    }
    // a name may be empty, but it is never a number
    if let Some(number) = header.iter().find(|field| is_number(field)) {
        return Err(format!(
            "line 1 has the number {} where joints are named: {} (`ros2 topic echo --csv` and `rostopic echo -p` write none that names joints: \
             save the message as YAML)",
            number,
            header_of(robot)
        ));
    }
    if let Some(column) = header.iter().position(str::is_empty) {
        return Err(format!("line 1: column {} has no name: {}", column + 1, header_of(robot)));
    }
    Ok(())
}

fn header_of(robot: &RobotModel) -> String {
    const MOST: usize = 20;
    let names = robot.position_names();
    let more = if names.len() > MOST { ", …" } else { "" };
    let names = names.iter().take(MOST).cloned().collect::<Vec<_>>().join(",");
    format!("a CSV of states begins with a header of joint names separated by commas, such as {names}{more}")
}

fn is_name(field: &str, robot: &RobotModel) -> bool {
    robot.joint_by_name(field).is_some() || robot.position_names().iter().any(|name| name == field)
}

/// Hint about fields that contain another separator than the comma.
fn separator_hint(record: &csv::StringRecord, robot: &RobotModel) -> Option<String> {
    let fields = || record.iter().filter(|field| !is_name(field, robot));
    let separator = [(';', "semicolons"), ('\t', "tabs"), ('|', "bars"), (' ', "blanks")]
        .into_iter()
        .find(|(separator, _)| fields().any(|field| field.contains(*separator)));
    separator.map(|(_, name)| {
        format!(": columns are separated by {name}: separate them by commas, and write decimals with a point")
    })
}

#[cfg(test)]
mod tests {
    use clearance::robot::MeshFiles;

    use super::*;

    fn read_csv(text: &str) -> Result<Vec<Vec<f64>>, String> {
        let urdf = "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>
            <joint name='j1' type='continuous'><parent link='a'/><child link='b'/></joint>
            <joint name='j 2' type='continuous'><parent link='b'/><child link='c'/></joint></robot>";
        let robot = RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap();
        let states = read(Path::new("q.CSV"), text, &robot)?;
        Ok(states.states.into_iter().map(|state| state.positions).collect())
    }

    #[test]
    fn commas_separate_columns() {
        let expected = Ok(vec![vec![0.5, -1.0], vec![1.0, 2.0]]);
        for text in [
            "j1,j 2\n0.5,-1\n1,2\n",
            "\u{feff}j1, j 2\r\n0.5, -1\r\n\r\n1, 2",
            "\"j1\",\"j 2\"\n\"0.5\",\"-1\"\n1,2\n",
        ] {
            assert_eq!(read_csv(text), expected, "{text}");
        }
    }

    #[test]
    fn errors_about_other_tables_take_one_line() {
        for (text, words) in [
            ("", &["empty", "header of joint names", "j1,j 2"][..]),
            (" \n\n", &["empty"]),
            ("0.5,1\n1,2\n", &["line 1 has numbers only", "header", "j1,j 2"]),
            ("0.5\n", &["numbers only"]),
            ("j1;j 2\n0.5;1\n", &["line 1: columns are separated by semicolons", "commas"]),
            ("0,5;1,0\n1,5;2,0\n", &["semicolons", "decimals with a point"]),
            ("j1\tj 2\n0.5\t1\n", &["separated by tabs"]),
            ("j1 | j 2\n", &["separated by bars"]),
            ("j1 j3\n0.5 1\n", &["separated by blanks"]),
            ("j1,j 2\n0.5;1\n", &["line 2: 1 values for 2 joints", "semicolons"]),
            ("j1,j 2\n0.5\t,1\t2\n", &["line 2", "tabs"]),
            ("j1,j 2\n0.5,1,2\n", &["line 2: 3 values for 2 joints"]),
            ("j1,j 2\n0.5,\n", &["line 2: '' is not a number"]),
            ("j1,j 2\n\n0.5,x\n", &["line 3: 'x' is not a number"]),
            ("j1,,j 2\n0,0,0\n", &["column 2 has no name"]),
            // `ros2 topic echo --csv`
            (
                "1700,25,base,j1,j 2,0.5,1.0,,\n1701,25,base,j1,j 2,0.6,1.0,,\n",
                &["line 1", "1700", "header", "--csv", "YAML"],
            ),
            ("1700,25,,j1,0.5\n", &["line 1", "--csv"]),
            // `rostopic echo -p`
            (
                "%time,field.header.seq,field.name0,field.position0\n1,2,j1,0.5\n",
                &["rostopic echo -p", "without -p"],
            ),
            ("1700000,3,1700000,base,j1,0.5\n", &["rostopic echo -p", "header"]),
        ] {
            let message = read_csv(text).unwrap_err();
            for word in words {
                assert!(message.contains(word), "{text:?}: {message}");
            }
            assert!(!message.contains('\n'), "{message}");
        }
    }

    #[test]
    fn a_header_alone_is_no_state() {
        assert_eq!(read_csv("j1,j 2\n"), Ok(vec![]));
    }
}
