//! Where the consumer polls, and where the sentinel stands.

use lodestone_client::latency::{allowed_processors, pin_to};

use super::super::failure::Failure;

/// The processors that the measurement uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Processors {
    /// The consumer's.
    pub(super) own: usize,
    /// The sentinel's; `None` if there is one processor only.
    pub(super) other: Option<usize>,
}

impl Processors {
    /// The one asked for, else the last that this process may use; the sentinel takes the first other.
    pub(super) fn choose(asked: Option<usize>) -> Result<Self, Failure> {
        let allowed = allowed_processors().map_err(|e| Failure::Other(e.to_string()))?;
        Self::among(&allowed, asked)
    }

    fn among(allowed: &[usize], asked: Option<usize>) -> Result<Self, Failure> {
        let own = asked.or_else(|| allowed.last().copied());
        let Some(own) = own.filter(|own| allowed.contains(own)) else {
            let allowed: Vec<String> = allowed.iter().map(ToString::to_string).collect();
            return Err(Failure::Usage(format!("--cpu: allowed: {}", allowed.join(", "))));
        };
        Ok(Self { own, other: allowed.iter().copied().find(|cpu| *cpu != own) })
    }

    /// Keeps the calling thread on the consumer's.
    pub(super) fn pin(self) -> Result<(), Failure> {
        pin_to(self.own).map_err(|e| Failure::Other(format!("--cpu {}: {e}", self.own)))
    }

    pub(super) fn warnings(self) -> Vec<String> {
        let alone = "one processor only: this consumer keeps the lanes from it, and no sentinel tells \
                     gaps apart";
        self.other.is_none().then(|| alone.to_owned()).into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn consumer_and_sentinel_stand_apart() {
        let choose = |allowed: &[usize], asked| Processors::among(allowed, asked).ok();
        assert_eq!(choose(&[0, 1], None), Some(Processors { own: 1, other: Some(0) }));
        assert_eq!(choose(&[2, 5, 7], Some(2)), Some(Processors { own: 2, other: Some(5) }));
        assert_eq!(choose(&[3], None), Some(Processors { own: 3, other: None }));
        assert_eq!(choose(&[0, 1], Some(9)), None);
        assert_eq!(Processors { own: 0, other: None }.warnings().len(), 1);
    }
}
