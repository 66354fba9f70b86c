//! The cameras' sensor units: HID devices that the daemon must read and write.

use rustix::fs::{Access, access};

use super::finding::Finding;
use super::machine::{Machine, Rights, field};

/// Stereolabs, and the sensor units of ZED 2 and ZED 2i, as `/sys` writes them.
const VENDOR: &str = "2B03";
const PRODUCTS: [(&str, &str); 2] = [("F781", "ZED 2"), ("F881", "ZED 2i")];
const RULES: &str = "60-lodestone-zed2.rules";
const RULE_DIRECTORIES: [&str; 4] =
    ["/etc/udev/rules.d", "/usr/lib/udev/rules.d", "/lib/udev/rules.d", "/run/udev/rules.d"];
const INSTALL: &str = "sudo cp config/udev/60-lodestone-zed2.rules /etc/udev/rules.d/ && \
                       sudo udevadm control --reload && sudo udevadm trigger, then plug the camera in again";

/// A sensor unit that is plugged in.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Unit {
    model: &'static str,
    serial: Option<String>,
    node: String,
}

pub(super) fn check(machine: &Machine) -> Vec<Finding> {
    let units = units(machine);
    let has_rules = RULE_DIRECTORIES.iter().any(|d| machine.exists(&format!("{d}/{RULES}")));
    let mut found: Vec<Finding> = units
        .iter()
        .map(|unit| {
            let allowed =
                access(machine.path(&unit.node), Access::READ_OK | Access::WRITE_OK).is_ok();
            judge(unit, machine.rights(&unit.node), allowed)
        })
        .collect();
    if units.is_empty() {
        found.push(Finding::unknown("camera", "no ZED 2 or ZED 2i is plugged in"));
    }
    found.push(rules(has_rules));
    found
}

fn units(machine: &Machine) -> Vec<Unit> {
    let of = |node: &String| {
        let uevent = machine.read(&format!("/sys/class/hidraw/{node}/device/uevent")).ok()?;
        let (model, serial) = sensor_unit(&uevent)?;
        Some(Unit { model, serial, node: format!("/dev/{node}") })
    };
    machine.names_in("/sys/class/hidraw").iter().filter_map(of).collect()
}

/// Model and serial number by the device's `uevent`: `HID_ID=0003:00002B03:0000F781`.
fn sensor_unit(uevent: &str) -> Option<(&'static str, Option<String>)> {
    let mut id = field(uevent, "HID_ID=")?.split(':').skip(1);
    let (vendor, product) = (id.next()?, id.next()?);
    let ends = |text: &str, with: &str| text.to_ascii_uppercase().ends_with(with);
    let (_, model) = PRODUCTS.iter().find(|(number, _)| ends(product, number))?;
    let serial = field(uevent, "HID_UNIQ=").filter(|serial| !serial.is_empty());
    ends(vendor, VENDOR).then(|| (*model, serial.map(str::to_owned)))
}

fn judge(unit: &Unit, rights: Option<Rights>, allowed: bool) -> Finding {
    const NAME: &str = "camera";
    let serial = unit.serial.as_ref().map_or_else(String::new, |s| format!(" serial {s}"));
    let Some(Rights { uid, gid, mode }) = rights else {
        return Finding::bad(NAME, format!("{}{serial}: {} is not there", unit.model, unit.node))
            .means("this process sees no device nodes (a container without /dev?)")
            .change(
                "give it the device: --device, DeviceAllow=char-hidraw rw, or PrivateDevices=no",
            );
    };
    let found = format!(
        "{}{serial} at {}, user {uid}, group {gid}, mode {mode:04o}",
        unit.model, unit.node
    );
    if !allowed {
        return Finding::bad(NAME, found)
            .means("this user cannot open it; the daemon of this user would wait for the camera for ever")
            .change(format!("{INSTALL}; and be a member of group lodestone"));
    }
    if mode & 0o006 != 0 {
        return Finding::better(NAME, found)
            .means("every process may switch its stream off")
            .change(INSTALL);
    }
    if mode & 0o060 != 0o060 {
        return Finding::better(NAME, found)
            .means("only its owner can open it, and a daemon should not run as root")
            .change(INSTALL);
    }
    Finding::ok(NAME, found)
}

fn rules(there: bool) -> Finding {
    const NAME: &str = "udev rules";
    if there {
        return Finding::ok(NAME, format!("{RULES} is installed"));
    }
    Finding::better(NAME, format!("{RULES} is not installed"))
        .means("a camera belongs to root alone, and USB may suspend its sensor unit")
        .change(INSTALL)
}

#[cfg(test)]
mod tests {
    use super::super::finding::Verdict;
    use super::*;

    const UEVENT: &str = "DRIVER=hid-generic\nHID_ID=0003:00002B03:0000F881\nHID_UNIQ=34567890\n";

    #[test]
    fn a_sensor_unit_is_known_by_vendor_and_product() {
        assert_eq!(sensor_unit(UEVENT), Some(("ZED 2i", Some("34567890".into()))));
        assert_eq!(sensor_unit(&UEVENT.replace("2B03", "046D")), None);
        for odd in ["", "HID_ID=", "HID_ID=0003", "HID_ID=::", "HID_ID=0003:2b03:é"] {
            assert_eq!(sensor_unit(odd), None, "{odd}");
        }
    }

    #[test]
    fn rights_of_the_node_are_judged() {
        let unit = Unit { model: "ZED 2", serial: None, node: "/dev/hidraw0".into() };
        let of =
            |mode, allowed| judge(&unit, Some(Rights { uid: 0, gid: 990, mode }), allowed).verdict;
        assert_eq!(of(0o660, true), Verdict::Ok);
        assert_eq!(of(0o660, false), Verdict::Bad);
        assert_eq!(of(0o666, true), Verdict::Better);
        assert_eq!(of(0o600, true), Verdict::Better);
        assert_eq!(judge(&unit, None, false).verdict, Verdict::Bad);
    }
}
