// Products of at most 18 bits become embedded multipliers: of 9x9 bits, or 18x18. Their registers are taken
// later, where there are any (flow/cyclone4/absorb.py).

(* techmap_celltype = "$mul" *)
module cyclone4_product (A, B, Y);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  parameter A_WIDTH = 1;
  parameter B_WIDTH = 1;
  parameter Y_WIDTH = 1;
  input [A_WIDTH-1:0] A;
  input [B_WIDTH-1:0] B;
  output [Y_WIDTH-1:0] Y;

  localparam LONGER = A_WIDTH > B_WIDTH ? A_WIDTH : B_WIDTH;
  localparam WIDTH = LONGER > 9 ? 18 : 9;
  localparam SIGNED = A_SIGNED && B_SIGNED;
  wire _TECHMAP_FAIL_ = LONGER > 18 || Y_WIDTH > 2 * WIDTH;

  wire [WIDTH-1:0] a, b;
  wire [2*WIDTH-1:0] product, y;
  \$pos #(.A_SIGNED(SIGNED), .A_WIDTH(A_WIDTH), .Y_WIDTH(WIDTH)) extend_a (.A(A), .Y(a));
  \$pos #(.A_SIGNED(SIGNED), .A_WIDTH(B_WIDTH), .Y_WIDTH(WIDTH)) extend_b (.A(B), .Y(b));
  cycloneiv_mac_mult #(
    .dataa_width(WIDTH), .datab_width(WIDTH), .dataa_clock("none"), .datab_clock("none")
  ) multiplier (
    .dataa(a), .datab(b), .signa(SIGNED[0]), .signb(SIGNED[0]), .clk(1'b0), .ena(1'b1), .dataout(product)
  );
  cycloneiv_mac_out #(
    .dataa_width(2 * WIDTH), .output_clock("none")
  ) result (
    .dataa(product), .clk(1'b0), .ena(1'b1), .dataout(y)
  );
  assign Y = y[Y_WIDTH-1:0];
endmodule
