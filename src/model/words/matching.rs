//! Claims and resources, each claim with a resource of its own.

use super::ResourceId;

/// Matches claims to resources; `options` has what would serve each claim. Kuhn's augmenting paths: time grows with
/// claims × options.
///
/// # Errors
/// The first claim that finds no resource of its own beside those before it, however these are served.
pub fn match_claims(options: &[Vec<ResourceId>]) -> Result<(), usize> {
    let count = options.iter().flatten().map(|resource| resource.index() + 1).max().unwrap_or(0);
    let mut owner = vec![None; count];
    let is_short = |claim: &usize| !augment(*claim, options, &mut owner, &mut vec![false; count]);
    match (0..options.len()).find(is_short) {
        Some(claim) => Err(claim),
        None => Ok(()),
    }
}

fn augment(claim: usize, options: &[Vec<ResourceId>], owner: &mut [Option<usize>], seen: &mut [bool]) -> bool {
    options[claim].iter().any(|resource| {
        let resource = resource.index();
        if std::mem::replace(&mut seen[resource], true) {
            return false;
        }
        let is_free = owner[resource].is_none_or(|other| augment(other, options, owner, seen));
        if is_free {
            owner[resource] = Some(claim);
        }
        is_free
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(options: &[&[u32]], expected: Result<(), usize>) {
        let options: Vec<Vec<_>> =
            options.iter().map(|claim| claim.iter().map(|&resource| ResourceId(resource)).collect()).collect();
        assert_eq!(match_claims(&options), expected, "{options:?}");
    }

    #[test]
    fn every_claim_needs_a_resource_of_its_own() {
        check(&[], Ok(()));
        check(&[&[]], Err(0));
        check(&[&[0], &[0]], Err(1));
        check(&[&[0, 1], &[0]], Ok(()));
        check(&[&[0, 1], &[1, 2], &[0], &[2]], Err(3));
        // Thirteen claims on twelve resources: exponential for a search that tries one choice after the other.
        let all: Vec<u32> = (0..12).collect();
        check(&[all.as_slice(); 13], Err(12));
    }
}
