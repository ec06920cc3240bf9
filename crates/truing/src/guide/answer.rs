use std::fmt::Write as _;

use probe_comp::GuidePoint;
use serde::Serialize;

use crate::Header;

/// Answer of `truing guide`; serialises as its JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Guides {
    /// Kind of the case.
    pub kind: &'static str,
    /// Version of this crate.
    pub version: &'static str,
    /// Form, program, inputs and provenance.
    #[serde(flatten)]
    pub header: Header,
    /// Radius of the ball.
    pub tip_radius_mm: f64,
    /// Places of the lattice where a ball that moves along z does not touch the part.
    pub beside_the_part: usize,
    /// Every guide point.
    pub guides: Vec<Guide>,
    /// Notes the user should read.
    pub warnings: Vec<String>,
}

/// Where a ball is sent, moving along z, and where it will touch the part as drawn.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Guide {
    /// Name of the touch.
    pub touch: String,
    /// G, on the part as drawn.
    pub guide_x_mm: f64,
    /// As `guide_x_mm`.
    pub guide_y_mm: f64,
    /// As `guide_x_mm`.
    pub guide_z_mm: f64,
    /// Ball's centre above it, O.
    pub center_x_mm: f64,
    /// As `center_x_mm`.
    pub center_y_mm: f64,
    /// As `center_x_mm`.
    pub center_z_mm: f64,
    /// Contact, A = O − r n.
    pub contact_x_mm: f64,
    /// As `contact_x_mm`.
    pub contact_y_mm: f64,
    /// As `contact_x_mm`.
    pub contact_z_mm: f64,
    /// Unit normal at the contact, towards the ball.
    pub normal_x: f64,
    /// As `normal_x`.
    pub normal_y: f64,
    /// As `normal_x`.
    pub normal_z: f64,
    /// Angles between the normal and the axes.
    pub angle_x_deg: f64,
    /// As `angle_x_deg`.
    pub angle_y_deg: f64,
    /// As `angle_x_deg`.
    pub angle_z_deg: f64,
}

impl Guide {
    pub(super) fn of(name: &str, point: &GuidePoint) -> Self {
        let n = point.normal;
        // By both legs: an arc cosine loses half of the digits near the axis.
        let angle = |k: usize| {
            let across = (0..3).filter(|j| *j != k).map(|j| n[j] * n[j]).sum::<f64>().sqrt();
            across.atan2(n[k]).to_degrees()
        };
        Self {
            touch: name.to_owned(),
            guide_x_mm: point.guide_mm.x,
            guide_y_mm: point.guide_mm.y,
            guide_z_mm: point.guide_mm.z,
            center_x_mm: point.center_mm.x,
            center_y_mm: point.center_mm.y,
            center_z_mm: point.center_mm.z,
            contact_x_mm: point.point_mm.x,
            contact_y_mm: point.point_mm.y,
            contact_z_mm: point.point_mm.z,
            normal_x: n.x,
            normal_y: n.y,
            normal_z: n.z,
            angle_x_deg: angle(0),
            angle_y_deg: angle(1),
            angle_z_deg: angle(2),
        }
    }
}

impl Guides {
    /// All guide points as a table, lengths to a nanometre.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "touch,guide_x_mm,guide_y_mm,guide_z_mm,center_x_mm,center_y_mm,center_z_mm,\
             contact_x_mm,contact_y_mm,contact_z_mm,normal_x,normal_y,normal_z,angle_x_deg,\
             angle_y_deg,angle_z_deg\n",
        );
        for g in &self.guides {
            text.push_str(&g.touch);
            let numbers = [
                g.guide_x_mm,
                g.guide_y_mm,
                g.guide_z_mm,
                g.center_x_mm,
                g.center_y_mm,
                g.center_z_mm,
                g.contact_x_mm,
                g.contact_y_mm,
                g.contact_z_mm,
                g.normal_x,
                g.normal_y,
                g.normal_z,
                g.angle_x_deg,
                g.angle_y_deg,
                g.angle_z_deg,
            ];
            for number in numbers {
                let _ = write!(text, ",{number:.6}");
            }
            text.push('\n');
        }
        text
    }

    /// The rows of `touches.csv` to be filled in: names and guide points, the readings empty.
    #[must_use]
    pub fn touches_csv(&self) -> String {
        let mut text = String::from("touch,guide_x_mm,guide_y_mm,x_mm,y_mm,z_mm\n");
        for g in &self.guides {
            let _ = writeln!(text, "{},{:.6},{:.6},,,", g.touch, g.guide_x_mm, g.guide_y_mm);
        }
        text
    }
}
