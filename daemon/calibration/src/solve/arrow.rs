//! The normal equations: one block for each knot, coupled to the next knot and to the recording's
//! parameters (an arrow), solved by eliminating knot after knot.

use nalgebra::{Cholesky, SMatrix, SVector};

use super::parameters::{GLOBALS, GlobalStep, LOCALS, LocalStep};

pub(crate) type LocalBlock = SMatrix<f64, LOCALS, LOCALS>;
pub(crate) type Border = SMatrix<f64, LOCALS, GLOBALS>;
pub(crate) type GlobalBlock = SMatrix<f64, GLOBALS, GLOBALS>;

/// Rows of one knot.
#[derive(Clone, Debug)]
struct Row {
    diagonal: LocalBlock,
    /// To the next knot.
    next: LocalBlock,
    border: Border,
    gradient: LocalStep,
}

/// The equations `H x = −g`, and the cost they belong to.
#[derive(Clone, Debug)]
pub(crate) struct Arrow {
    rows: Vec<Row>,
    globals: GlobalBlock,
    gradient: GlobalStep,
    /// Sum of weighted squares.
    pub(crate) cost: f64,
}

/// What solving gives.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    pub(crate) globals: GlobalStep,
    pub(crate) locals: Vec<LocalStep>,
    /// Covariance of the recording's parameters, the knots integrated out.
    pub(crate) covariance: GlobalBlock,
    /// Logarithm of the determinant of `H`.
    pub(crate) log_determinant: f64,
}

/// A residual of `N` components of one knot, with its Jacobians and its weight.
pub(crate) struct Residual<const N: usize> {
    pub(crate) value: SVector<f64, N>,
    pub(crate) local: SMatrix<f64, N, LOCALS>,
    pub(crate) global: SMatrix<f64, N, GLOBALS>,
    /// One over the variance.
    pub(crate) weight: f64,
}

impl Arrow {
    pub(crate) fn new(knots: usize) -> Self {
        let row = Row {
            diagonal: LocalBlock::zeros(),
            next: LocalBlock::zeros(),
            border: Border::zeros(),
            gradient: LocalStep::zeros(),
        };
        Self {
            rows: vec![row; knots],
            globals: GlobalBlock::zeros(),
            gradient: GlobalStep::zeros(),
            cost: 0.0,
        }
    }

    /// Adds a residual of one knot; its cost is the caller's, who may have bounded it.
    pub(crate) fn add<const N: usize>(&mut self, knot: usize, r: &Residual<N>) {
        let row = &mut self.rows[knot];
        let (local, global) = (r.local.transpose() * r.weight, r.global.transpose() * r.weight);
        row.diagonal += local * r.local;
        row.border += local * r.global;
        row.gradient += local * r.value;
        self.globals += global * r.global;
        self.gradient += global * r.value;
    }

    /// Adds a residual between a knot and the next one, whose Jacobian is `next`.
    pub(crate) fn add_link<const N: usize>(
        &mut self,
        knot: usize,
        r: &Residual<N>,
        next: &SMatrix<f64, N, LOCALS>,
    ) {
        self.add(knot, r);
        let weighted = next.transpose() * r.weight;
        self.rows[knot].next += r.local.transpose() * r.weight * next;
        let row = &mut self.rows[knot + 1];
        row.diagonal += weighted * next;
        row.border += weighted * r.global;
        row.gradient += weighted * r.value;
    }

    /// Adds knowledge of one of the recording's parameters: it is off by `error`.
    pub(crate) fn add_prior(&mut self, at: usize, error: f64, sigma: f64) {
        let weight = (sigma * sigma).recip();
        self.globals[(at, at)] += weight;
        self.gradient[at] += weight * error;
        self.cost += weight * error * error;
    }

    /// Adds knowledge of a function of the recording's parameters.
    pub(crate) fn add_global(&mut self, error: f64, jacobian: &GlobalStep, sigma: f64) {
        let weight = (sigma * sigma).recip();
        self.globals += jacobian * jacobian.transpose() * weight;
        self.gradient += jacobian * (weight * error);
        self.cost += weight * error * error;
    }

    /// Solves with every diagonal element raised by `damping` times itself; `None` if the
    /// equations are not positive definite in numbers.
    pub(crate) fn solve(mut self, damping: f64) -> Option<Solution> {
        self.damp(damping);
        let mut factors = Vec::with_capacity(self.rows.len());
        let mut log_determinant = 0.0;
        for k in 0..self.rows.len() {
            let factor = self.eliminate(k)?;
            log_determinant += log_det(factor.l_dirty().diagonal().as_slice());
            factors.push(factor);
        }
        let factor = Cholesky::new(self.globals)?;
        log_determinant += log_det(factor.l_dirty().diagonal().as_slice());
        let globals = -factor.solve(&self.gradient);
        let locals = self.substitute(&factors, &globals);
        Some(Solution { globals, locals, covariance: factor.inverse(), log_determinant })
    }

    fn damp(&mut self, damping: f64) {
        for row in &mut self.rows {
            for i in 0..LOCALS {
                row.diagonal[(i, i)] *= 1.0 + damping;
            }
        }
        for i in 0..GLOBALS {
            self.globals[(i, i)] *= 1.0 + damping;
        }
    }

    /// Takes one knot out of the rows after it (the Schur complement).
    fn eliminate(&mut self, k: usize) -> Option<Cholesky<f64, nalgebra::Const<LOCALS>>> {
        let row = self.rows[k].clone();
        let factor = Cholesky::new(row.diagonal)?;
        let (border, gradient) = (factor.solve(&row.border), factor.solve(&row.gradient));
        self.globals -= row.border.transpose() * border;
        self.gradient -= row.border.transpose() * gradient;
        if let Some(after) = self.rows.get_mut(k + 1) {
            let next = row.next.transpose();
            after.diagonal -= next * factor.solve(&row.next);
            after.border -= next * border;
            after.gradient -= next * gradient;
        }
        Some(factor)
    }

    fn substitute(
        &self,
        factors: &[Cholesky<f64, nalgebra::Const<LOCALS>>],
        globals: &GlobalStep,
    ) -> Vec<LocalStep> {
        let mut locals = vec![LocalStep::zeros(); factors.len()];
        let mut after = LocalStep::zeros();
        for (k, factor) in factors.iter().enumerate().rev() {
            let row = &self.rows[k];
            after = -factor.solve(&(row.gradient + row.border * globals + row.next * after));
            locals[k] = after;
        }
        locals
    }
}

fn log_det(diagonal: &[f64]) -> f64 {
    2.0 * diagonal.iter().map(|l| l.ln()).sum::<f64>()
}
