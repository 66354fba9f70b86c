//! A depth source before there is a daemon, and after.

mod support;

use lodestone_client::{CloudFields, ConnectError, PublishError, monotonic_now_ns};
use support::TestDomain;

#[test]
fn a_source_may_start_first_and_leaves_nothing_where_no_daemon_ever_ran() {
    // Given a domain that nobody has made
    let domain = TestDomain::shared();
    let client = domain.client();
    let mut source = client.cloud_publisher("front", 10).unwrap();
    let refused = source.loan(2, 1).map(|_| ()).unwrap_err();
    assert!(matches!(refused, PublishError::Connect(ConnectError::NoDaemon { .. })), "{refused}");
    assert!(!std::path::Path::new(&domain.root).exists());
    // When a daemon makes it, and goes
    drop(client.domain().open_node("daemon").unwrap());
    // Then the same source works, and a consumer gets what it sends
    let mut clouds = client.clouds("front").unwrap();
    assert_eq!(source.loan(2, 1).unwrap().send(monotonic_now_ns()).unwrap(), 0);
    assert!(clouds.next().is_none(), "nothing waits for who was not there");
    let mut cloud = source.loan(3, 2).unwrap().with_fields(CloudFields::COLOUR);
    assert!(cloud.points_mut().iter().all(|p| p.position_m[2].is_nan()), "no depth yet");
    cloud.points_mut()[5].position_m = [0.0, 0.0, 2.0];
    assert_eq!(cloud.with_depth_sigma_per_m(0.01).send(7).unwrap(), 1);
    let received = clouds.next().expect("waits");
    assert_eq!((received.info().time_ns(), received.info().sequence()), (7, 1));
    assert_eq!(received.info().depth_sigma_per_m(), Some(0.01));
    assert_eq!(received[5].position_m.map(f32::to_bits), [0.0, 0.0, 2.0_f32].map(f32::to_bits));
}

#[test]
fn what_is_no_cloud_is_refused() {
    let client = TestDomain::shared().client();
    assert!(matches!(client.cloud_publisher("front", 0), Err(PublishError::NoPoints)));
    assert!(matches!(client.cloud_publisher("Front", 1), Err(PublishError::Name(_))));
    let mut source = client.cloud_publisher("refused", 10).unwrap();
    for (width, height) in [(11, 1), (u32::MAX, u32::MAX), (65_536, 65_536)] {
        let refused = source.loan(width, height).map(|_| ()).unwrap_err();
        assert!(refused.to_string().contains("allowed: 10"), "{refused}");
    }
    assert!(matches!(source.loan(3, 0).map(|_| ()), Err(PublishError::NoPoints)));
}
