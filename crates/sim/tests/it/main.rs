//! Scenes, from their text to the files of a run.

#![expect(clippy::print_stdout, reason = "tests tell what they measured")]

mod ball;
mod belt;
mod branches;
mod buckling;
mod capstan;
mod charging;
mod common;
mod compliant;
mod contact;
mod crossed;
mod crossing;
mod drum;
mod ends;
mod feed;
mod grippers;
mod grooms;
mod joints;
mod knot;
mod laboratory;
mod laws;
mod ledger;
mod mass_spring;
mod meshes;
mod messages;
mod objects;
mod probes;
mod reference;
mod rest;
mod rigid;
mod rolling;
mod runs;
mod scenes;
mod stacks;
mod starts;
mod stepper;
mod stick_slip;
mod strip;
mod supports;
mod surfaces;
mod taper;
mod touches;
mod usd;
mod water_wave;
mod wet_pair;
