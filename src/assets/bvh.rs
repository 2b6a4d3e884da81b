//! Reads Biovision hierarchies (BVH): any skeleton, any order of channels. Its own reader: errors name the line.

use glam::{Quat, Vec3};

use super::rig_motion::{RigJoint, RigMotion};

/// Most joints of a skeleton; finger-captured ones have about 80.
const MAX_JOINTS: usize = 1024;
/// Most numbers of all frames: an hour of 80 joints at 120 Hz.
const MAX_NUMBERS: usize = 120_000_000;

/// Why a motion file can't be read.
#[derive(Debug, thiserror::Error)]
#[error("{file}, line {line}: {what}")]
pub struct MotionFileError {
    /// The file.
    pub file: String,
    /// The line, counted from 1.
    pub line: usize,
    /// What is wrong, with the remedy.
    pub what: String,
}

/// One number of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Channel {
    Position(usize),
    Rotation(usize),
}

/// Words with the lines they stand in.
struct Words<'a> {
    file: &'a str,
    words: std::iter::Peekable<Box<dyn Iterator<Item = (usize, &'a str)> + 'a>>,
    line: usize,
}

impl<'a> Words<'a> {
    fn new(file: &'a str, text: &'a str) -> Self {
        let lines = text.lines().enumerate();
        let words = lines.flat_map(|(i, line)| line.split_whitespace().map(move |word| (i + 1, word)));
        let words: Box<dyn Iterator<Item = (usize, &'a str)> + 'a> = Box::new(words);
        Self { file, words: words.peekable(), line: 1 }
    }

    fn error(&self, what: impl Into<String>) -> MotionFileError {
        MotionFileError { file: self.file.to_owned(), line: self.line, what: what.into() }
    }

    fn next(&mut self, expected: &str) -> Result<&'a str, MotionFileError> {
        let Some((line, word)) = self.words.next() else {
            return Err(self.error(format!(
                "the file ends where {expected} should stand; it is cut off: export or download it again"
            )));
        };
        self.line = line;
        Ok(word)
    }

    fn keyword(&mut self, expected: &str) -> Result<(), MotionFileError> {
        let found = self.next(expected)?;
        if found.eq_ignore_ascii_case(expected) {
            return Ok(());
        }
        Err(self
            .error(format!("`{found}` stands where `{expected}` should; this is not a BVH file as known")))
    }

    fn number(&mut self, what: &str) -> Result<f32, MotionFileError> {
        let word = self.next(what)?;
        let number = word.parse::<f32>().ok().filter(|n| n.is_finite());
        number.ok_or_else(|| self.error(format!("`{word}` is not a finite number where {what} should stand")))
    }

    fn count(&mut self, what: &str, most: usize) -> Result<usize, MotionFileError> {
        let word = self.next(what)?;
        let count = word.parse::<usize>().ok().filter(|n| *n <= most);
        count.ok_or_else(|| self.error(format!("`{word}` is not a count up to {most} of {what}")))
    }

    fn vector(&mut self) -> Result<Vec3, MotionFileError> {
        let mut axis = || self.number("an offset");
        Ok(Vec3::new(axis()?, axis()?, axis()?))
    }
}

/// Reads a motion from the text of a BVH file; `file` stands in errors, `name` becomes the motion's.
///
/// Rotations are composed in the order their channels stand in, as the format demands; only the root's position
/// channels are used. Angles are degrees in the file.
///
/// # Errors
/// [`MotionFileError`] with the line: another keyword than the format's, a number that is none, a second root,
/// a file that ends early, or one larger than an hour of capture.
pub fn read_bvh(file: &str, name: &str, text: &str) -> Result<RigMotion, MotionFileError> {
    let mut words = Words::new(file, text);
    words.keyword("HIERARCHY")?;
    words.keyword("ROOT")?;
    let mut skeleton = Skeleton::default();
    skeleton.joint(&mut words)?;
    words.keyword("MOTION")?;
    words.keyword("Frames:")?;
    let most = MAX_NUMBERS / skeleton.channels.len().max(1);
    let frames = words.count("frames", most)?;
    words.keyword("Frame")?;
    words.keyword("Time:")?;
    let frame_seconds = words.number("the frame time")?;
    if frame_seconds <= 0.0 {
        return Err(
            words.error(format!("a frame time of {frame_seconds} s; write the seconds from frame to frame"))
        );
    }
    let mut motion = RigMotion {
        name: name.to_owned(),
        joints: skeleton.joints,
        frame_seconds,
        root: Vec::new(),
        rotations: Vec::new(),
    };
    for _ in 0..frames {
        read_frame(&mut words, &skeleton.channels, &mut motion)?;
    }
    match words.words.next() {
        None => Ok(motion),
        Some((line, word)) => {
            words.line = line;
            Err(words
                .error(format!("`{word}` stands behind the last of {frames} frames; correct their count")))
        }
    }
}

#[derive(Default)]
struct Skeleton {
    joints: Vec<RigJoint>,
    channels: Vec<(usize, Channel)>,
}

impl Skeleton {
    /// The hierarchy behind the word `ROOT`, without recursion: files decide how deep it is.
    fn joint(&mut self, words: &mut Words<'_>) -> Result<(), MotionFileError> {
        let mut open: Vec<usize> = Vec::new();
        self.begin(words, &mut open)?;
        while let Some(current) = open.last().copied() {
            match words.next("a joint's content")?.to_ascii_uppercase().as_str() {
                "JOINT" => self.begin(words, &mut open)?,
                "CHANNELS" => self.channels(words, current)?,
                "END" => {
                    words.keyword("Site")?;
                    words.keyword("{")?;
                    words.keyword("OFFSET")?;
                    self.joints[current].tip = Some(words.vector()?);
                    words.keyword("}")?;
                }
                "}" => {
                    open.pop();
                }
                other => {
                    return Err(words.error(format!("`{other}` is nothing that a joint can have in BVH")));
                }
            }
        }
        Ok(())
    }

    fn begin(&mut self, words: &mut Words<'_>, open: &mut Vec<usize>) -> Result<(), MotionFileError> {
        if self.joints.len() == MAX_JOINTS {
            return Err(words.error(format!("more than {MAX_JOINTS} joints; simplify the skeleton")));
        }
        let name = words.next("a joint's name")?.to_owned();
        words.keyword("{")?;
        words.keyword("OFFSET")?;
        let offset = words.vector()?;
        open.push(self.joints.len());
        let parent = open.len().checked_sub(2).map(|above| open[above]);
        self.joints.push(RigJoint { name, parent, offset, tip: None });
        Ok(())
    }

    fn channels(&mut self, words: &mut Words<'_>, joint: usize) -> Result<(), MotionFileError> {
        for _ in 0..words.count("channels", 6)? {
            let word = words.next("a channel")?;
            let lower = word.to_ascii_lowercase();
            let axis = ["x", "y", "z"].iter().position(|axis| lower.starts_with(axis));
            let channel = match (axis, lower.get(1..)) {
                (Some(axis), Some("position")) => Channel::Position(axis),
                (Some(axis), Some("rotation")) => Channel::Rotation(axis),
                _ => {
                    return Err(
                        words.error(format!("`{word}` is no channel; BVH knows Xposition to Zrotation"))
                    );
                }
            };
            self.channels.push((joint, channel));
        }
        Ok(())
    }
}

fn read_frame(
    words: &mut Words<'_>,
    channels: &[(usize, Channel)],
    motion: &mut RigMotion,
) -> Result<(), MotionFileError> {
    let mut rotations = vec![Quat::IDENTITY; motion.joints.len()];
    let mut root = motion.joints.first().map_or(Vec3::ZERO, |joint| joint.offset);
    for (joint, channel) in channels {
        let number = words.number("a frame's number")?;
        match channel {
            Channel::Position(axis) if *joint == 0 => root[*axis] = number,
            Channel::Position(_) => {}
            Channel::Rotation(axis) => {
                let turn = Quat::from_axis_angle(Vec3::AXES[*axis], number.to_radians());
                rotations[*joint] *= turn;
            }
        }
    }
    motion.root.push(root);
    motion.rotations.push(rotations);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = "HIERARCHY
ROOT hips
{
  OFFSET 0 0 0
  CHANNELS 6 Zposition Xposition Yposition Yrotation Xrotation Zrotation
  JOINT leg
  {
    OFFSET 1 -2 0.5
    CHANNELS 3 Xrotation Zrotation Yrotation
    End Site
    {
      OFFSET 0 -4 0
    }
  }
  JOINT spine
  {
    OFFSET 0 3 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 1 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.025
3 1 2 90 0 0 30 0 0 0 0 0
0 0 0 0 0 0 90 90 0 10 20 30
";

    #[test]
    fn skeleton_and_channels_of_any_order_are_read() {
        let motion = read_bvh("small.bvh", "small", SMALL).expect("a motion");
        let names: Vec<_> = motion.joints.iter().map(|j| (&*j.name, j.parent, j.offset)).collect();
        let expected = [
            ("hips", None, Vec3::ZERO),
            ("leg", Some(0), Vec3::new(1.0, -2.0, 0.5)),
            ("spine", Some(0), Vec3::new(0.0, 3.0, 0.0)),
        ];
        assert_eq!(names, expected);
        assert_eq!(motion.joints[1].tip, Some(Vec3::new(0.0, -4.0, 0.0)));
        assert_eq!(motion.frame_seconds, 0.025);
        assert_eq!(motion.root, [Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO]);
        // Rx(90) Rz(90) in this order takes x to z: first about z (x to y), then about x (y to z).
        let turned = motion.rotations[1][1] * Vec3::X;
        assert!(turned.distance(Vec3::Z) < 1e-5, "{turned}");
    }

    #[test]
    fn world_rotations_follow_the_tree() {
        let motion = read_bvh("small.bvh", "small", SMALL).expect("a motion");
        let world = motion.world_rotations(0);
        // The hips turn 90 degrees about y, the leg then 30 about its own x, which is the world's -z.
        let expected = Quat::from_rotation_y(90f32.to_radians()) * Quat::from_rotation_x(30f32.to_radians());
        assert!(world[1].angle_between(expected) < 1e-3);
        assert_eq!(motion.rest_positions()[1], Vec3::new(1.0, -2.0, 0.5));
    }

    #[test]
    fn faults_name_their_line() {
        let fault = |text: &str| read_bvh("f.bvh", "f", text).expect_err("a fault");
        let error = fault(&SMALL.replace("OFFSET 0 3 0", "OFFSET 0 three 0"));
        assert_eq!((error.line, error.what.contains("three")), (17, true), "{error}");
        assert_eq!(fault(&SMALL.replace("Zrotation Yrotation\n", "Wrotation Yrotation\n")).line, 9);
        assert_eq!(fault(&SMALL.replace("0.025", "0")).line, 27);
        assert!(fault(&SMALL.replace("10 20 30\n", "10 20\n")).what.contains("cut off"));
        assert_eq!(fault(&SMALL.replace("Frames: 2", "Frames: 1")).line, 29);
        assert!(fault(&SMALL.replace("Frames: 2", "Frames: 99999999999")).what.contains("count"));
        assert_eq!(fault(&SMALL.replace("10 20 30", "10 nan 30")).line, 29);
        assert!(fault("solid mesh").what.contains("HIERARCHY"));
    }
}
