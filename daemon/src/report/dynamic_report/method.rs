//! How the methods are called and drawn.

use super::super::page::legend;
use super::super::plot::{Mark, key};
use crate::evaluation::dynamic::method::Method;

/// Class of a method's colour and line.
pub(super) const fn class(method: Method) -> &'static str {
    match method {
        Method::Raw => "before",
        Method::OffsetCorrected => "paper",
        Method::LowPassed => "paper dashed",
        Method::LodestoneUnaided => "ours dashed",
        Method::Lodestone => "ours",
        Method::LodestoneCalibrated => "ours heavy",
    }
}

/// What a method is called.
pub(in crate::report) const fn name(method: Method) -> &'static str {
    match method {
        Method::Raw => "raw",
        Method::OffsetCorrected => "offset-corrected",
        Method::LowPassed => "low-pass",
        Method::LodestoneUnaided => "Lodestone, no standstills",
        Method::Lodestone => "Lodestone",
        Method::LodestoneCalibrated => "Lodestone, calibrated",
    }
}

/// What a method is, in a sentence.
const fn meaning(method: Method) -> &'static str {
    match method {
        Method::Raw => "samples integrated as they come",
        Method::OffsetCorrected => "mean of 10 s of rest taken off before",
        Method::LowPassed => "the same through a low-pass of 10 Hz",
        Method::LodestoneUnaided => "its filter on its own",
        Method::Lodestone => "its filter as shipped",
        Method::LodestoneCalibrated => "with <code>lodestoned calibrate</code> before",
    }
}

/// The attribute of cells that matter most: Lodestone as it should be used.
pub(in crate::report) fn emphasis(method: Method) -> &'static str {
    if method == Method::LodestoneCalibrated { " class=\"best\"" } else { "" }
}

/// All methods with their lines.
pub(super) fn legend_of_all() -> String {
    let entry = |method: Method| {
        let what = format!("<b>{}</b>: {}", name(method), meaning(method));
        (key(Mark::Line, class(method)), what)
    };
    legend(&Method::ALL.map(entry))
}
