mod clock; mod peak; mod record;
fn main(){
 for _ in 0..3 {
 let p=peak::multiply_adds(); 
 for rate in [100,1000] { let k=peak::linear_kernel(rate); println!("peak {:.2} G/s; kernel {rate} {:.4} ns share {:.3}",p/1e9,k*1e9, 6.0/k/p); }
 let (a,b)=peak::nonlinear_kernel(); println!("nonlinear {:.3} {:.3} ratio {:.2}",a*1e9,b*1e9,b/a);
 }
}
