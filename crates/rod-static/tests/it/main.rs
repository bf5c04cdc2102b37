//! Equilibria of a rod, against closed forms and references.

mod assemblies;
mod bifurcations;
mod boundary;
mod branches;
mod closed_form;
mod common;
mod couples;
mod derivatives;
mod elliptic;
mod followers;
mod limits;
mod loads;
mod minima;
mod properties;
mod several;
mod switching;
mod targets;
