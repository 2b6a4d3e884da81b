#[path = "../src/scene/field/test_room.rs"] mod test_room;
use inhabit::scene::*; use inhabit::math::Aabb;
fn main(){ let n: usize = std::env::args().nth(1).unwrap().parse().unwrap();
 let bounds = Aabb { min: test_room::LOW, max: test_room::HIGH }.grown(0.35);
 let c=FieldConfig { resolution: Resolution::Exactly { dim: [n; 3], bounds }, ..FieldConfig::default() };
 let t=test_room::triangles(100_000);
 for _ in 0..2 {let s=std::time::Instant::now(); bake(&t,&c,&|_,_| std::ops::ControlFlow::Continue(())).unwrap(); eprintln!("total {:?}",s.elapsed());} }
