// Tables of up to four inputs become cells in normal mode; inputs that a table does not have are tied high.

module \$lut (A, Y);
  parameter WIDTH = 0;
  parameter LUT = 0;
  (* force_downto *) input [WIDTH-1:0] A;
  output Y;

  generate
    if (WIDTH > 4)
      wire _TECHMAP_FAIL_ = 1;
    else if (WIDTH == 1)
      cycloneiv_lcell_comb #(.lut_mask({8{LUT[1:0]}}), .sum_lutc_input("datac")) _TECHMAP_REPLACE_ (
        .combout(Y), .dataa(A[0]), .datab(1'b1), .datac(1'b1), .datad(1'b1));
    else if (WIDTH == 2)
      cycloneiv_lcell_comb #(.lut_mask({4{LUT[3:0]}}), .sum_lutc_input("datac")) _TECHMAP_REPLACE_ (
        .combout(Y), .dataa(A[0]), .datab(A[1]), .datac(1'b1), .datad(1'b1));
    else if (WIDTH == 3)
      cycloneiv_lcell_comb #(.lut_mask({2{LUT[7:0]}}), .sum_lutc_input("datac")) _TECHMAP_REPLACE_ (
        .combout(Y), .dataa(A[0]), .datab(A[1]), .datac(A[2]), .datad(1'b1));
    else
      cycloneiv_lcell_comb #(.lut_mask(LUT[15:0]), .sum_lutc_input("datac")) _TECHMAP_REPLACE_ (
        .combout(Y), .dataa(A[0]), .datab(A[1]), .datac(A[2]), .datad(A[3]));
  endgenerate
endmodule
