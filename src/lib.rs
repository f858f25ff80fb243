//! **morsemill**: from a freeform part to chips on a 3-axis mill.
//!
//! Read the folders from top to bottom and you have read the pipeline:
//!
//! ```text
//! part -> reach -> morse -> field -> feature -> toolpath -> cldata -> post -> text -> gcode -> simulate
//!  mesh    c, p     critical   phi     regions    moves      steps    dialect         events    verdict
//!                   points                                    | |                       |
//!                                              APT CL file <--+ +--- translate <--------+-> link =bytes= controller
//! ```
//!
//! Two halves meet at *text*: nothing right of `text` can see what the left half intended, so the dry run judges what the
//! machine will be told and nothing else.
//!
//! # Who may know whom
//!
//! Everyone may use the shared words ([`geom`], [`units`], [`tool`], [`machine`], [`sweep`]). Beyond those, each module may use
//! what stands to its left in its own row:
//!
//! ```text
//! part   reach   morse   field   feature   toolpath   cldata   post   shape in, text out
//! - - - - - - - - - -  program text  - - - - - - - - - -          the only bridge
//! gcode   kinematics   simulate                                   text in, motion out (simulate also reads part and reach:
//!                                                                 what should be left standing)
//! gcode   kinematics   wire   link                                the host side of the cable
//! gcode   kinematics   wire   controller                          the far side; link and controller never meet
//! toolpath   cldata   post   gcode   verify                       the witness
//! cldata   gcode   translate                                      a program of one dialect as steps for any other
//! toolpath   kinematics   weigh                                   what a toolpath takes, before there is text
//! ```
//!
//! `cli` knows all of them, and is the only place that prints, asks or names files.

pub mod cldata;
pub mod cli;
pub mod controller;
pub mod feature;
pub mod field;
pub mod gcode;
pub mod geom;
pub mod kinematics;
pub mod link;
pub mod machine;
pub mod morse;
pub mod part;
pub mod picture;
pub mod post;
pub mod reach;
pub mod simulate;
pub mod sweep;
pub mod tool;
pub mod toolpath;
pub mod translate;
pub mod units;
pub mod verify;
pub mod weigh;
pub mod wire;
