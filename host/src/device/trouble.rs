//! Why a serial port cannot be opened, in terms of what ends it: the group to join, the program that holds it.

use std::io::{Error as IoError, ErrorKind};
use std::path::Path;

use serial2::SerialPort;

use crate::error::Error;

/// The device error for `name` that could not be opened.
pub fn cannot_open(name: &str, error: &IoError) -> Error {
    let (why, remedy) = match error.kind() {
        ErrorKind::PermissionDenied => ("this user may not use the port".to_owned(), permission(name)),
        ErrorKind::ResourceBusy => busy(name),
        // macOS and Linux say EBUSY by its number on old systems; Windows calls a busy port denied.
        _ if error.raw_os_error() == Some(16) => busy(name),
        _ => (error.to_string(), format!("name a serial port ({}) or tcp://host:port", ports())),
    };
    Error::device(format!("{name}: {why}"), remedy)
}

/// The ports there are.
pub fn ports() -> String {
    let ports = SerialPort::available_ports().unwrap_or_default();
    let found: Vec<String> = ports.iter().map(|port| port.display().to_string()).collect();
    if found.is_empty() { "none is there: plug the board in".to_owned() } else { found.join(", ") }
}

fn busy(name: &str) -> (String, String) {
    match holder(name) {
        Some(holder) => (
            format!("the port is in use by {holder}"),
            "close that program (a serial monitor, an IDE, another motorlens) and try again".into(),
        ),
        None => (
            "the port is in use by another program".into(),
            "close whatever has it open: a serial monitor, an IDE, ModemManager, another motorlens".into(),
        ),
    }
}

/// Which group opens the port, and how to join it.
#[cfg(unix)]
fn permission(name: &str) -> String {
    use std::os::unix::fs::MetadataExt;
    let group = std::fs::metadata(name).ok().and_then(|about| {
        let (gid, mode) = (about.gid(), about.mode());
        // A group that may read and write, and is not the owner of everything.
        (mode & 0o060 == 0o060 && gid != 0).then(|| group_name(gid).unwrap_or_else(|| gid.to_string()))
    });
    match group {
        Some(group) => format!(
            "the port belongs to the group {group}: sudo usermod -aG {group} $USER, then log out and in again (or, for now, sudo chmod a+rw {name})"
        ),
        None => format!("sudo chmod a+rw {name}, or add a udev rule that gives the port to a group of yours"),
    }
}

#[cfg(not(unix))]
fn permission(_name: &str) -> String {
    "close whatever has the port open: a serial monitor, an IDE, another motorlens".into()
}

#[cfg(unix)]
fn group_name(gid: u32) -> Option<String> {
    group_in(&std::fs::read_to_string("/etc/group").ok()?, gid)
}

/// The name of a group in the text of /etc/group.
#[cfg(unix)]
fn group_in(groups: &str, gid: u32) -> Option<String> {
    groups.lines().find_map(|line| {
        let mut fields = line.split(':');
        let (name, _, number) = (fields.next()?, fields.next()?, fields.next()?);
        (number.parse() == Ok(gid)).then(|| name.to_owned())
    })
}

/// The program that has the file `name` open, where the system tells (Linux): its name and process number.
pub fn holder(name: &str) -> Option<String> {
    let wanted = Path::new(name).canonicalize().ok()?;
    let own = std::process::id().to_string();
    let processes = std::fs::read_dir("/proc").ok()?;
    processes.filter_map(Result::ok).find_map(|process| {
        let number =
            process.file_name().into_string().ok().filter(|n| n.bytes().all(|b| b.is_ascii_digit()))?;
        if number == own {
            return None;
        }
        let mut files = std::fs::read_dir(process.path().join("fd")).ok()?.filter_map(Result::ok);
        files.find(|file| std::fs::read_link(file.path()).is_ok_and(|to| to == wanted))?;
        let program = std::fs::read_to_string(process.path().join("comm")).unwrap_or_default();
        Some(format!("{} (process {number})", program.trim()))
    })
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn the_group_of_a_port_is_named() {
        let text = permission("/dev/null");
        assert!(text.contains("udev"), "{text}");
        assert_eq!(group_in("root:x:0:\ndialout:x:20:ada\n", 20).as_deref(), Some("dialout"));
        assert_eq!(group_in("root:x:0:\n", 20), None);
    }

    #[test]
    fn the_program_that_holds_a_port_is_named() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("port");
        let file = std::fs::File::create(&path).unwrap();
        let mut child = std::process::Command::new("sleep").arg("20").stdout(file).spawn().unwrap();
        let found = holder(path.to_str().unwrap());
        let (why, remedy) = busy(path.to_str().unwrap());
        child.kill().unwrap();
        child.wait().unwrap();
        assert_eq!(found, Some(format!("sleep (process {})", child.id())));
        assert!(why.contains("in use by sleep") && remedy.contains("close"), "{why} {remedy}");
    }

    #[test]
    fn permission_and_absence_lead_to_different_remedies() {
        let denied = cannot_open("/dev/ttyNONE", &IoError::from(ErrorKind::PermissionDenied)).to_string();
        assert!(denied.contains("may not use") && denied.contains("chmod"), "{denied}");
        let absent = cannot_open("/dev/ttyNONE", &IoError::from(ErrorKind::NotFound)).to_string();
        assert!(absent.contains("name a serial port"), "{absent}");
    }
}
